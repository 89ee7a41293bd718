// The mesh format of a file name.
#pragma once

#include <filesystem>
#include <optional>

namespace scanknit {

enum class MeshFormat { kGlb, kPly, kObj, kStl, kThreeMf, kTiles, kStep };

inline constexpr const char* kMeshExtensions = ".glb .ply .obj .stl .3mf .tiles";
inline constexpr const char* kReadableMeshExtensions = ".glb .ply .obj .stl .step .stp";

/// The format of the extension, in upper or lower case.
[[nodiscard]] std::optional<MeshFormat> mesh_format(const std::filesystem::path& path);

}  // namespace scanknit
