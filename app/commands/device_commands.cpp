// devices, doctor, udev-rules: list scanners, find why one does not work, and give access to them.
#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "acquire/device_rules.h"
#include "acquire/device_source.h"
#include "acquire/diagnose_devices.h"
#include "acquire/openni2/openni2_plugin.h"
#include "app/commands.h"
#include "app/exit_codes.h"

namespace scanknit {
namespace {

using Json = nlohmann::ordered_json;

/// JSON as text. Names come from devices and may not be UTF-8.
std::string dumped(const Json& json) {
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

Json device_json(const DeviceInfo& device) {
  return {{"uri", device.uri},
          {"name", device.name},
          {"serial", device.serial.empty() ? Json() : Json(device.serial)},
          {"bus", device.bus > 0 ? Json(device.bus) : Json()},
          {"address", device.bus > 0 ? Json(device.address) : Json()},
          {"speed_mbit", device.speed_mbit > 0 ? Json(device.speed_mbit) : Json()},
          {"support", device.support}};
}

std::string device_line(const DeviceInfo& device) {
  // For a camera of a module, only its driver knows the USB port.
  if (device.bus == 0) return fmt::format("{}  {}, {}\n", device.uri, device.name, device.support);
  return fmt::format("{}  {}, bus {} address {}, {} Mbit/s, {}\n", device.uri, device.name, device.bus, device.address,
                     device.speed_mbit, device.support);
}

const char* to_string(Finding::Grade grade) {
  switch (grade) {
    case Finding::Grade::kGood: return "ok";
    case Finding::Grade::kNote: return "note";
    case Finding::Grade::kProblem: return "problem";
  }
  return "";
}

Json findings_json(const std::vector<Finding>& findings) {
  Json json = Json::array();
  for (const Finding& finding : findings) {
    json.push_back({{"grade", to_string(finding.grade)},
                    {"text", finding.text},
                    {"remedy", finding.remedy.empty() ? Json() : Json(finding.remedy)}});
  }
  return json;
}

std::string findings_lines(const std::vector<Finding>& findings) {
  std::string lines;
  for (const Finding& finding : findings) {
    lines += fmt::format("  {:8} {}\n", to_string(finding.grade), finding.text);
    if (!finding.remedy.empty()) lines += fmt::format("  {:8} -> {}\n", "", finding.remedy);
  }
  return lines;
}

Json diagnosis_json(const Diagnosis& diagnosis) {
  Json devices = Json::array();
  for (const DeviceDiagnosis& each : diagnosis.devices) {
    Json json = device_json(each.device);
    json["findings"] = findings_json(each.findings);
    devices.push_back(json);
  }
  return {{"system", findings_json(diagnosis.system)}, {"devices", devices}};
}

std::string diagnosis_lines(const Diagnosis& diagnosis) {
  std::string lines = "System\n" + findings_lines(diagnosis.system);
  for (const DeviceDiagnosis& each : diagnosis.devices)
    lines += device_line(each.device) + findings_lines(each.findings);
  return lines;
}

}  // namespace

int devices_command(const CommonArguments& common) {
  const auto cameras = list_cameras();
  if (!cameras) return fail(cameras.error(), common);
  const auto openni2 = load_openni2();
  if (!openni2 && common.verbosity == Verbosity::kVerbose) {
    Console(common.verbosity).info("OpenNI2 cameras are not listed: " + openni2.error().message);
  }
  if (common.is_json) {
    Json devices = Json::array();
    for (const DeviceInfo& camera : *cameras) devices.push_back(device_json(camera));
    return print_result(dumped({{"devices", devices}}), common);
  }
  if (cameras->empty()) Console(common.verbosity).info("no depth camera is plugged in; scanknit doctor tells more");
  std::string lines;
  for (const DeviceInfo& camera : *cameras) lines += device_line(camera);
  return print_result(lines, common);
}

int doctor_command(const CommonArguments& common) {
  const auto diagnosis = diagnose_devices();
  if (!diagnosis) return fail(diagnosis.error(), common);
  const int printed =
      print_result(common.is_json ? dumped(diagnosis_json(*diagnosis)) : diagnosis_lines(*diagnosis), common);
  if (printed != kExitOk) return printed;
  return diagnosis->has_problem() ? exit_code_of(ErrorCode::kDevice) : kExitOk;
}

int udev_rules_command(const std::string& device, const CommonArguments& common) {
  if (device.empty()) return print_result(udev_rules(), common);
  const auto rules = udev_rules_for(device);
  if (!rules) return fail(rules.error(), common);
  return print_result(*rules, common);
}

}  // namespace scanknit
