// What the .mtl files beside an OBJ say about transparency.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <unordered_map>

namespace antumbra {

class ObjMaterials {
  public:
    /// Lines that are not understood are skipped. Linear time; memory up to that of the text.
    void read(std::span<const std::byte> text);
    /// `d` below 1, `Tr` above 0 where there is no `d` (writers disagree on its sense), or a `map_d`.
    bool see_through(const std::string& material) const;

  private:
    struct Material {
        double opacity = 1, transparency = 0;
        bool has_opacity = false, has_map = false;
    };
    std::unordered_map<std::string, Material> materials_;
};

} // namespace antumbra
