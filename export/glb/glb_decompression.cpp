#include "export/glb/glb_decompression.h"

#include <meshoptimizer.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <span>
#include <utility>

#include "core/checked_math.h"
#include "core/files/byte_reader.h"
#include "export/glb/glb_container.h"
#include "export/mesh/mesh_builder.h"

namespace scanknit {
namespace {

constexpr const char* kExtension = "EXT_meshopt_compression";
// A flat, evenly coloured surface shrinks to little; more than this per byte of the file is not believed.
constexpr std::size_t kMaxExpansion = 512;

struct Chunks {
  std::string_view json, binary;
};

/// check_glb_container() has found them whole.
Chunks chunks_of(std::string_view glb) {
  constexpr std::size_t kHeader = 12, kChunkHeader = 8;
  const auto length_at = [&](std::size_t offset) {
    ByteReader reader(std::as_bytes(std::span(glb.substr(offset))));
    return static_cast<std::size_t>(reader.little_endian<std::uint32_t>().value_or(0));
  };
  Chunks chunks;
  chunks.json = glb.substr(kHeader + kChunkHeader, length_at(kHeader));
  const std::size_t next = kHeader + kChunkHeader + chunks.json.size();
  if (glb.size() >= next + kChunkHeader) chunks.binary = glb.substr(next + kChunkHeader, length_at(next));
  return chunks;
}

std::size_t count_in(const nlohmann::json& object, const char* key) {
  const auto found = object.find(key);
  return found != object.end() && found->is_number_unsigned() ? found->get<std::size_t>() : 0;
}

bool uses_extension(const nlohmann::json& json) {
  const nlohmann::json required = json.value("extensionsRequired", nlohmann::json::array());
  return required.is_array() &&
         std::find(required.begin(), required.end(), nlohmann::json(kExtension)) != required.end();
}

Result<std::string> unfolded(const nlohmann::json& packed, std::string_view binary, std::size_t most_bytes) {
  const std::size_t offset = count_in(packed, "byteOffset"), length = count_in(packed, "byteLength");
  const std::size_t stride = count_in(packed, "byteStride"), count = count_in(packed, "count");
  if (count_in(packed, "buffer") != 0 || offset > binary.size() || length > binary.size() - offset) {
    return input_error("compressed data of the GLB lies outside its buffer");
  }
  if (packed.value("filter", "NONE") != "NONE") {
    return input_error("the GLB is compressed with filters, which are not supported");
  }
  const auto bytes = checked_mul(count, stride);
  if (!bytes || *bytes > most_bytes) return input_error("the GLB unfolds to more than is believed");
  std::string plain(*bytes, '\0');
  const auto* source = reinterpret_cast<const unsigned char*>(binary.data() + offset);
  const std::string mode = packed.value("mode", "");
  int fault = -1;
  if (mode == "ATTRIBUTES" && stride > 0 && stride <= 256 && stride % 4 == 0) {
    fault = meshopt_decodeVertexBuffer(plain.data(), count, stride, source, length);
  } else if (mode == "TRIANGLES" && (stride == 2 || stride == 4) && count % 3 == 0) {
    fault = meshopt_decodeIndexBuffer(plain.data(), count, stride, source, length);
  } else if (mode == "INDICES" && (stride == 2 || stride == 4)) {
    fault = meshopt_decodeIndexSequence(plain.data(), count, stride, source, length);
  }
  if (fault != 0) return input_error("compressed data of the GLB is damaged");
  return plain;
}

void forget_extension(nlohmann::json& json, const char* list) {
  const auto found = json.find(list);
  if (found == json.end() || !found->is_array()) return;
  found->erase(std::remove(found->begin(), found->end(), nlohmann::json(kExtension)), found->end());
  if (found->empty()) json.erase(found);
}

}  // namespace

Result<std::optional<std::string>> without_meshopt(std::string_view glb, const Limits& limits) {
  const Chunks chunks = chunks_of(glb);
  if (chunks.json.find(kExtension) == std::string_view::npos) return std::optional<std::string>();
  nlohmann::json json = nlohmann::json::parse(chunks.json, nullptr, /*allow_exceptions=*/false);
  if (!json.is_object()) return input_error("the GLB's JSON cannot be understood");
  if (!uses_extension(json)) return std::optional<std::string>();
  const std::uintmax_t most_bytes =
      std::min<std::uintmax_t>({limits.max_mesh_bytes, kMaxExpansion * (glb.size() + 1), (1ull << 32) - (1 << 24)});
  std::string binary(chunks.binary);
  const auto views = json.find("bufferViews");
  for (std::size_t i = 0; views != json.end() && views->is_array() && i < views->size(); ++i) {
    nlohmann::json& view = (*views)[i];
    if (!view.is_object() || !view.contains("extensions") || !view["extensions"].is_object()) continue;
    const auto packed = view["extensions"].find(kExtension);
    if (packed == view["extensions"].end()) continue;
    const std::size_t left = most_bytes - std::min<std::size_t>(most_bytes, binary.size());
    const auto plain = unfolded(*packed, chunks.binary, left);
    if (!plain) return plain.error();
    binary.resize((binary.size() + 3) / 4 * 4, '\0');
    view["buffer"] = 0;
    view["byteOffset"] = binary.size();
    view["byteLength"] = plain->size();
    view.erase("extensions");
    binary += *plain;
  }
  json["buffers"] = nlohmann::json::array({{{"byteLength", binary.size()}}});
  forget_extension(json, "extensionsUsed");
  forget_extension(json, "extensionsRequired");
  return std::optional<std::string>(glb_container(json.dump(), binary));
}

}  // namespace scanknit
