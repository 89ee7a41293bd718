// The table of all configuration keys. The parser, `config print`, the JSON Schema and docs/configuration.md use it.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
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
  kList,        ///< some of `choices`, in order, none of them twice
  kTopic,       ///< the name of a topic of ROS: letters, digits, and / _ - . ~
  kPath,        ///< the name of a file or folder
  kIntrinsics,  ///< [fx, fy, cx, cy], a map, or the name of a file
  kCamera,      ///< the name of a CAMERA.yaml
};

/// A value of any key. monostate: `auto`, if the key allows it. Numbers and lengths (metres) are doubles; integers and
/// memory (MiB) are int64; an enum is its word.
using ConfigValue = std::variant<std::monostate, bool, std::int64_t, double, std::string, std::vector<std::string>,
                                 CameraModel, std::shared_ptr<const ScannerCamera>>;

struct ConfigKey {
  std::string name;  ///< dotted: "fusion.voxel_size"
  ConfigType type = ConfigType::kNumber;
  std::string unit;    ///< "m", "1/m", "voxels" ...; may be empty
  double minimum = 0;  ///< inclusive; for numbers, lengths, integers, memory
  double maximum = 0;  ///< inclusive
  std::vector<std::string> choices;
  bool allows_auto = false;
  std::string text;  ///< what the key does, in one or two sentences
  std::function<ConfigValue(const ScanConfig&)> get;
  std::function<void(ScanConfig&, const ConfigValue&)> set;  ///< the value's type must be the key's
};

/// A memory budget that is `auto`: load_config() chooses one.
inline constexpr std::int64_t kAutomaticBudgetMib = 0;

/// What the program begins with: the members' defaults, with budgets of memory that are `auto`.
[[nodiscard]] ScanConfig built_in_config();

/// All keys, in the order of printing; the keys of a section follow one another.
[[nodiscard]] std::span<const ConfigKey> config_schema();

/// Null if there is no such key.
[[nodiscard]] const ConfigKey* find_config_key(std::string_view name);

/// Parses a value that is one word. Errors (kConfig, without `where`): not of the key's type, or out of its range. For
/// kList: a list of one entry. For kIntrinsics and kCamera: only `auto`.
[[nodiscard]] Result<ConfigValue> parse_config_word(const ConfigKey& key, std::string_view word);

/// The allowed range: "0.0002..0.1 m"; for enums and lists the words: "linear, mid_edge".
[[nodiscard]] std::string format_config_range(const ConfigKey& key);

}  // namespace scanknit
