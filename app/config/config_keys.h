// Functions that make the keys of the schema's tables, in a line or two for each.
#pragma once

#include <algorithm>
#include <cstdint>
#include <string>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#include "app/config/config_schema.h"
#include "core/check.h"

namespace scanknit::config_keys {

/// The members that all kinds of keys have.
struct Key {
  std::string name;
  std::string unit = {};
  std::string text = {};
};

struct Range {
  double minimum, maximum;
};

template <typename E>
using Words = std::vector<std::pair<std::string, E>>;

inline ConfigKey describe(ConfigType type, const Key& key, Range range = {0, 0}) {
  ConfigKey described;
  described.name = key.name;
  described.type = type;
  described.unit = key.unit;
  described.text = key.text;
  described.minimum = range.minimum;
  described.maximum = range.maximum;
  return described;
}

/// `field` is a generic lambda: ScanConfig& -> reference to the member, const ScanConfig& -> const reference.
template <typename Stored, typename Field>
void bind_plain(ConfigKey& key, Field field) {
  key.get = [field](const ScanConfig& config) { return ConfigValue(static_cast<Stored>(field(config))); };
  key.set = [field](ScanConfig& config, const ConfigValue& value) {
    using Member = std::remove_cvref_t<decltype(field(config))>;
    field(config) = static_cast<Member>(std::get<Stored>(value));
  };
}

/// For a std::optional member: `auto` is std::nullopt.
template <typename Stored, typename Field>
void bind_optional(ConfigKey& key, Field field) {
  key.allows_auto = true;
  key.get = [field](const ScanConfig& config) {
    const auto& member = field(config);
    return member ? ConfigValue(static_cast<Stored>(*member)) : ConfigValue();
  };
  key.set = [field](ScanConfig& config, const ConfigValue& value) {
    auto& member = field(config);
    member.reset();
    using Member = typename std::remove_cvref_t<decltype(member)>::value_type;
    if (const auto* given = std::get_if<Stored>(&value)) member = static_cast<Member>(*given);
  };
}

template <typename Field>
ConfigKey boolean(const Key& key, Field field) {
  ConfigKey described = describe(ConfigType::kBool, key);
  bind_plain<bool>(described, field);
  return described;
}

template <typename Field>
ConfigKey integer(const Key& key, Range range, Field field) {
  ConfigKey described = describe(ConfigType::kInteger, key, range);
  bind_plain<std::int64_t>(described, field);
  return described;
}

template <typename Field>
ConfigKey number(const Key& key, Range range, Field field) {
  ConfigKey described = describe(ConfigType::kNumber, key, range);
  bind_plain<double>(described, field);
  return described;
}

template <typename Field>
ConfigKey length(const Key& key, Range range_m, Field field) {
  ConfigKey described = describe(ConfigType::kLength, key, range_m);
  described.unit = "m";
  bind_plain<double>(described, field);
  return described;
}

/// For a std::optional member: see bind_optional.
template <typename Field>
ConfigKey optional_length(const Key& key, Range range_m, Field field) {
  ConfigKey described = describe(ConfigType::kLength, key, range_m);
  described.unit = "m";
  bind_optional<double>(described, field);
  return described;
}

/// For a std::optional member: see bind_optional.
template <typename Field>
ConfigKey optional_number(const Key& key, Range range, Field field) {
  ConfigKey described = describe(ConfigType::kNumber, key, range);
  bind_optional<double>(described, field);
  return described;
}

/// `auto` is 0 MiB, until load_config() chooses.
template <typename Field>
ConfigKey memory(const Key& key, Range range_mib, Field field) {
  ConfigKey described = describe(ConfigType::kMemory, key, range_mib);
  described.unit = "MiB";
  described.allows_auto = true;
  described.get = [field](const ScanConfig& config) {
    const auto mib = static_cast<std::int64_t>(field(config));
    return mib == kAutomaticBudgetMib ? ConfigValue() : ConfigValue(mib);
  };
  described.set = [field](ScanConfig& config, const ConfigValue& value) {
    using Member = std::remove_cvref_t<decltype(field(config))>;
    const auto* given = std::get_if<std::int64_t>(&value);
    field(config) = static_cast<Member>(given != nullptr ? *given : kAutomaticBudgetMib);
  };
  return described;
}

template <typename E>
std::string word_of(const Words<E>& words, E value) {
  const auto found = std::find_if(words.begin(), words.end(), [&](const auto& word) { return word.second == value; });
  SCANKNIT_CHECK(found != words.end());
  return found->first;
}

template <typename E>
E value_of(const Words<E>& words, const std::string& text) {
  const auto found = std::find_if(words.begin(), words.end(), [&](const auto& word) { return word.first == text; });
  SCANKNIT_CHECK(found != words.end());
  return found->second;
}

template <typename E>
ConfigKey describe_words(const Key& key, const Words<E>& words) {
  ConfigKey described = describe(ConfigType::kEnum, key);
  for (const auto& word : words) described.choices.push_back(word.first);
  return described;
}

template <typename E, typename Field>
ConfigKey choice(const Key& key, const Words<E>& words, Field field) {
  ConfigKey described = describe_words(key, words);
  described.get = [words, field](const ScanConfig& config) { return ConfigValue(word_of<E>(words, field(config))); };
  described.set = [words, field](ScanConfig& config, const ConfigValue& value) {
    field(config) = value_of(words, std::get<std::string>(value));
  };
  return described;
}

template <typename E, typename Field>
ConfigKey optional_choice(const Key& key, const Words<E>& words, Field field) {
  ConfigKey described = describe_words(key, words);
  described.allows_auto = true;
  described.get = [words, field](const ScanConfig& config) {
    const auto& member = field(config);
    return member ? ConfigValue(word_of<E>(words, *member)) : ConfigValue();
  };
  described.set = [words, field](ScanConfig& config, const ConfigValue& value) {
    auto& member = field(config);
    member.reset();
    if (const auto* word = std::get_if<std::string>(&value)) member = value_of(words, *word);
  };
  return described;
}

template <typename Field>
ConfigKey word_list(const Key& key, std::vector<std::string> choices, Field field) {
  ConfigKey described = describe(ConfigType::kList, key);
  described.choices = std::move(choices);
  bind_plain<std::vector<std::string>>(described, field);
  return described;
}

}  // namespace scanknit::config_keys

namespace scanknit {

/// The keys of `finish:`.
[[nodiscard]] std::vector<ConfigKey> finish_keys();

/// The keys of `acquire:` that say what a recording's files mean: camera, unit, topics, masks (recording_keys.cpp).
[[nodiscard]] std::vector<ConfigKey> recording_keys();

}  // namespace scanknit
