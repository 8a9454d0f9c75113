#!/usr/bin/env python3
"""Checks that the modules form a tree without circles.

usage: include_map.py ROOT   exits 1 and names every include that the map below does not allow.
"""
import pathlib
import re
import sys

# What a module may include besides itself. Each list holds direct permissions; they are followed transitively.
MAY_INCLUDE = {
    "base": [],
    "geometry": ["base"],
    "tree": ["geometry"],
    "raster": ["geometry"],
    "occluders": ["tree"],
    "pvs": ["geometry"],
    "occlusion_tree": ["occluders"],
    "cull": ["tree", "raster", "occluders", "occlusion_tree", "pvs"],
    "scene": ["geometry", "tree"],
    "import": ["scene"],
    "export": ["scene"],
    "generate": ["scene"],
    "rays": ["scene", "tree"],
    "occluder_finding": ["rays", "raster", "occluders"],
    "certify": ["pvs"],
    "bake": ["rays", "occluder_finding", "pvs", "certify"],
    "mos": ["bake", "tree", "raster"],
    "evaluate": ["mos", "bake", "cull", "import", "export", "generate"],
    "capi": ["cull"],
}
# Public headers and the module that each belongs to.
PUBLIC = {
    "status": "base", "job": "base", "math": "geometry", "scene": "scene", "import": "import", "export": "export",
    "generate": "generate", "camera": "import", "quake3": "import", "pvs": "pvs", "cull": "cull", "occluders": "occluders", "occluder_database": "occluders", "occluder_finding": "occluder_finding", "bake": "bake", "mos": "mos", "evaluate": "evaluate", "study": "evaluate", "antumbra": "capi",
    "explain": "evaluate", "compare": "evaluate",
    "split": "scene",
}
# The run time: closed under inclusion and free of everything but the standard library.
RUNTIME = {"base", "geometry", "tree", "raster", "occluders", "occlusion_tree", "pvs", "cull", "capi"}
SYSTEM_ONLY_IN = {"base": {"fcntl.h", "unistd.h", "sys/mman.h", "sys/stat.h"}}


def closure(module):
    seen, todo = set(), [module]
    while todo:
        name = todo.pop()
        if name not in seen:
            seen.add(name)
            todo.extend(MAY_INCLUDE[name])
    return seen


def module_of(path, root):
    relative = path.relative_to(root)
    if relative.parts[0] == "include":
        return PUBLIC.get(relative.stem)
    return relative.parts[1]


def main(root):
    errors = []
    for module in MAY_INCLUDE:
        for neighbour in MAY_INCLUDE[module]:
            if module in closure(neighbour):
                errors.append(f"the map itself has a circle through {module} and {neighbour}")
    if any(not closure(module) <= RUNTIME for module in RUNTIME):
        errors.append("the run time is not closed")
    files = [f for top in ("include", "src") for f in (root / top).rglob("*") if f.suffix in (".h", ".hpp", ".cpp")]
    for file in sorted(files):
        module = module_of(file, root)
        if module not in MAY_INCLUDE:
            errors.append(f"{file.relative_to(root)}: belongs to no module of the map")
            continue
        for line, text in enumerate(file.read_text().splitlines(), 1):
            match = re.match(r'\s*#\s*include\s+([<"])([^>"]+)[>"]', text)
            if not match:
                continue
            quote, name = match.groups()
            if name.startswith("antumbra/"):
                target = PUBLIC.get(pathlib.PurePath(name).stem)
            elif quote == '"':
                target = name.split("/")[0]
            else:
                own = "." not in name or name in SYSTEM_ONLY_IN.get(module, ()) or name in ("immintrin.h",)
                if module in RUNTIME and not own and not (module == "capi" and name.startswith("std")):
                    errors.append(f"{file.relative_to(root)}:{line}: the run time may not include <{name}>")
                continue
            if target not in closure(module):
                errors.append(f"{file.relative_to(root)}:{line}: {module} may not include {name}")
    for error in errors:
        print(error)
    print(f"{len(files)} files, {len(errors)} forbidden includes")
    return 1 if errors or not files else 0


if __name__ == "__main__":
    sys.exit(main(pathlib.Path(sys.argv[1])))
