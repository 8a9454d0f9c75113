"""What git tracks is source: nothing that a build makes, no path of one machine, no address of a package registry."""

import pathlib
import re
import subprocess
import sys

BUILT = re.compile(r"(^|/)(build|dist|node_modules|generated|__pycache__)/|\.(o|a|so|pyc|wasm|obj\.d|gch|pvs\.part)$")
OF_ONE_MACHINE = re.compile(r"(?<![\w.$}])/(work|home|root|Users)/\w|https?://registry\.|https?://[\w.-]*/artifactory/")
LARGEST = 1 << 20


def tracked(root):
    listing = subprocess.run(["git", "-C", root, "ls-files", "-z"], capture_output=True)
    if listing.returncode:
        print(f"{root} is no checkout; nothing to look at")
        sys.exit(77)
    return [name for name in listing.stdout.decode().split("\0") if name]


def faults(root):
    for name in tracked(root):
        path = pathlib.Path(root, name)
        if not path.is_file():
            continue
        if BUILT.search(name) and not name.startswith("tests/"):
            yield f"{name}: made by a build; take it out (git rm --cached) and add it to .gitignore"
        content = path.read_bytes()
        if len(content) > LARGEST:
            yield f"{name}: {len(content)} bytes; generate it where it is needed"
        if b"\0" in content or name == "tests/house/clean_tree.py":
            continue
        for number, line in enumerate(content.decode(errors="replace").splitlines(), 1):
            found = OF_ONE_MACHINE.search(line)
            if found:
                yield f"{name}:{number}: '{found.group()}' belongs to one machine"


if __name__ == "__main__":
    all_faults = list(faults(sys.argv[1]))
    print("\n".join(all_faults) or f"{len(tracked(sys.argv[1]))} tracked files, all of them source")
    sys.exit(1 if all_faults else 0)
