// The one table of configuration keys. The parser, `config print`, the JSON Schema and docs/configuration.md come from
// it.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "core/result.h"
#include "scan/scan_config.h"

namespace scanknit {

enum class ConfigType {
  kBool,
  kInteger,
  kNumber,
  kLength,      ///< metres; written "2mm", "0.4 cm", "3 m" or plain metres
  kMemory,      ///< mebibytes; written "512MiB", "2GiB" or plain mebibytes
  kEnum,        ///< one of `choices`
  kList,        ///< some of `choices`, in order, none twice
  kIntrinsics,  ///< [fx, fy, cx, cy], a map, or the name of a file
};

/// A value of any key. monostate: `auto`, where the key allows it. Numbers, lengths (metres) are doubles; integers and
/// memory (MiB) are int64; enums are their word.
using ConfigValue =
    std::variant<std::monostate, bool, std::int64_t, double, std::string, std::vector<std::string>, CameraModel>;

struct ConfigKey {
  std::string name;  ///< dotted: "fusion.voxel_size"
  ConfigType type = ConfigType::kNumber;
  std::string unit;    ///< "m", "1/m", "voxels" ...; may be empty
  double minimum = 0;  ///< included; of numbers, lengths, integers, memory
  double maximum = 0;  ///< included
  std::vector<std::string> choices;
  bool allows_auto = false;
  std::string text;  ///< what it does, one sentence or two
  std::function<ConfigValue(const ScanConfig&)> get;
  std::function<void(ScanConfig&, const ConfigValue&)> set;  ///< the value's type must be the key's
};

/// All keys, in the order in which they are printed; keys of one section are neighbours.
[[nodiscard]] std::span<const ConfigKey> config_schema();

/// Null when there is no such key.
[[nodiscard]] const ConfigKey* find_config_key(std::string_view name);

/// The value that one word stands for. Errors (kConfig, without `where`): not of the key's type, or out of its range.
/// For kList: a list of one. kIntrinsics has no such words but `auto`.
[[nodiscard]] Result<ConfigValue> parse_config_word(const ConfigKey& key, std::string_view word);

/// "0.0002..0.1 m"; for enums and lists "linear, mid_edge".
[[nodiscard]] std::string format_config_range(const ConfigKey& key);

}  // namespace scanknit
