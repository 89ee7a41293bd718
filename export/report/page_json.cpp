#include "export/report/page_json.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

namespace scanknit {
namespace {

using Json = nlohmann::ordered_json;

const Json kNothing;

const Json& value_of(const void* json) {
  return *static_cast<const Json*>(json);
}

}  // namespace

bool PageJson::is_object() const {
  return value_of(json_).is_object();
}
bool PageJson::is_array() const {
  return value_of(json_).is_array();
}
bool PageJson::is_number() const {
  return value_of(json_).is_number() && std::isfinite(value_of(json_).get<double>());
}
bool PageJson::is_string() const {
  return value_of(json_).is_string();
}
bool PageJson::is_boolean() const {
  return value_of(json_).is_boolean();
}
bool PageJson::is_null() const {
  return value_of(json_).is_null();
}

double PageJson::as_number() const {
  return is_number() ? value_of(json_).get<double>() : 0;
}

std::string PageJson::as_text() const {
  return is_string() ? value_of(json_).get<std::string>() : "";
}

bool PageJson::is_true() const {
  return is_boolean() && value_of(json_).get<bool>();
}

std::size_t PageJson::size() const {
  return is_structured() ? value_of(json_).size() : 0;
}

PageJson PageJson::operator[](std::size_t place) const {
  return PageJson(is_array() && place < size() ? &value_of(json_)[place] : &kNothing);
}

std::vector<std::pair<std::string, PageJson>> PageJson::items() const {
  std::vector<std::pair<std::string, PageJson>> items;
  if (!is_object()) return items;
  for (const auto& [key, value] : value_of(json_).items()) items.emplace_back(key, PageJson(&value));
  return items;
}

PageJson PageJson::at(const std::string& pointer) const {
  const Json* place = &value_of(json_);
  for (std::size_t begin = 1; begin <= pointer.size();) {
    const std::size_t end = std::min(pointer.find('/', begin), pointer.size());
    if (!place->is_object()) return PageJson(&kNothing);
    const auto found = place->find(pointer.substr(begin, end - begin));
    if (found == place->end()) return PageJson(&kNothing);
    place = &*found;
    begin = end + 1;
  }
  return PageJson(place);
}

std::string PageJson::dump() const {
  return value_of(json_).dump(-1, ' ', false, Json::error_handler_t::replace);
}

}  // namespace scanknit
