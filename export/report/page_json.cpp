#include "export/report/page_json.h"

#include <algorithm>
#include <cmath>

namespace scanknit {
namespace {

const ReportJson kNull;
const ReportJson kEmptyList = ReportJson::array();
const ReportJson kEmptyObject = ReportJson::object();

std::string on_one_line(const ReportJson& json) {
  return json.dump(-1, ' ', false, ReportJson::error_handler_t::replace);
}

void flatten(const ReportJson& json, const std::string& name, int depth, std::size_t most,
             std::vector<std::pair<std::string, std::string>>& rows) {
  constexpr int kMostDepth = 16;
  if (rows.size() >= most) return;
  if (!json.is_object() || json.empty() || depth > kMostDepth) {
    rows.emplace_back(name, depth > kMostDepth ? "..."
                            : json.is_string() ? json.get<std::string>()
                                               : on_one_line(json));
    return;
  }
  for (const auto& [key, value] : json.items()) {
    flatten(value, name.empty() ? key : name + "." + key, depth + 1, most, rows);
  }
}

}  // namespace

Result<ReportJson> parse_report(std::string_view text) {
  constexpr int kMostDepth = 64;
  bool is_too_deep = false;
  const auto watch = [&](int depth, ReportJson::parse_event_t, ReportJson&) {
    is_too_deep = is_too_deep || depth > kMostDepth;
    return !is_too_deep;
  };
  ReportJson json = ReportJson::parse(text, watch, /*allow_exceptions=*/false);
  if (is_too_deep || !json.is_object()) return Error{ErrorCode::kInput, "is no report: expected a JSON object"};
  return json;
}

const ReportJson& value_at(const ReportJson& json, std::string_view pointer) {
  const ReportJson* place = &json;
  for (std::size_t begin = 1; begin <= pointer.size();) {
    const std::size_t end = std::min(pointer.find('/', begin), pointer.size());
    if (!place->is_object()) return kNull;
    const auto found = place->find(std::string(pointer.substr(begin, end - begin)));
    if (found == place->end()) return kNull;
    place = &*found;
    begin = end + 1;
  }
  return *place;
}

const ReportJson& list_at(const ReportJson& json, std::string_view pointer) {
  const ReportJson& value = value_at(json, pointer);
  return value.is_array() ? value : kEmptyList;
}

const ReportJson& object_at(const ReportJson& json, std::string_view pointer) {
  const ReportJson& value = value_at(json, pointer);
  return value.is_object() ? value : kEmptyObject;
}

std::optional<double> number_of(const ReportJson& value) {
  if (!value.is_number() || !std::isfinite(value.get<double>())) return std::nullopt;
  return value.get<double>();
}

std::optional<double> number_at(const ReportJson& json, std::string_view pointer) {
  return number_of(value_at(json, pointer));
}

std::string text_at(const ReportJson& json, std::string_view pointer) {
  const ReportJson& value = value_at(json, pointer);
  return value.is_string() ? value.get<std::string>() : "";
}

std::vector<std::pair<std::string, std::string>> flattened(const ReportJson& json, std::size_t most) {
  std::vector<std::pair<std::string, std::string>> rows;
  flatten(json, "", 0, most, rows);
  return rows;
}

}  // namespace scanknit
