// Which mesh format a file's name asks for.
#pragma once

#include <filesystem>
#include <optional>

namespace scanknit {

enum class MeshFormat { kGlb, kPly, kObj, kStl, kThreeMf };

inline constexpr const char* kMeshExtensions = ".glb .ply .obj .stl .3mf";
inline constexpr const char* kReadableMeshExtensions = ".glb .ply .obj .stl";

/// By the extension, in any case.
[[nodiscard]] std::optional<MeshFormat> mesh_format(const std::filesystem::path& path);

}  // namespace scanknit
