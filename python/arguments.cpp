#include "python/arguments.h"

#include <fmt/ranges.h>

#include <array>
#include <string>
#include <string_view>
#include <utility>
#include <variant>

#include "extract/volume/sample_type.h"
#include "python/errors.h"

namespace py = pybind11;

namespace scanknit {
namespace {

using Path = std::filesystem::path;

constexpr double kMostFrames = 1e8, kLongest_s = 1e9;

OutputRequest output_request(const Path& output, Keywords& keywords) {
  OutputRequest request{.output = output};
  keywords.read("trajectory", request.trajectory);
  keywords.read("save_volume", request.volume);
  return request;
}

ScannerRequest scanner_request(Keywords& keywords) {
  ScannerRequest scanner;
  keywords.read("device", scanner.device);
  scanner.width = keywords.number<int>("width", 16, 8192).value_or(scanner.width);
  scanner.height = keywords.number<int>("height", 16, 8192).value_or(scanner.height);
  scanner.frames_per_second = keywords.number<double>("fps", 1, 1000).value_or(scanner.frames_per_second);
  scanner.frames = keywords.number<std::size_t>("frames", 1, kMostFrames);
  scanner.seconds = keywords.number<double>("seconds", 0.001, kLongest_s);
  if (scanner.frames && scanner.seconds) throw py::value_error("frames, seconds: give one of them");
  scanner.wait_s = keywords.number<double>("wait", 0, kLongest_s).value_or(scanner.wait_s);
  scanner.reconnect_s = keywords.number<double>("reconnect", 0, kLongest_s).value_or(scanner.reconnect_s);
  keywords.read("force", scanner.takes_from_others);
  return scanner;
}

/// True, False, or the file.
void read_recording(Keywords& keywords, CaptureArguments& arguments) {
  std::variant<bool, Path> recording = true;
  keywords.read("recording", recording);
  if (const bool* wanted = std::get_if<bool>(&recording)) {
    arguments.wants_recording = *wanted;
    return;
  }
  const Path& file = std::get<Path>(recording);
  if (file.extension() != ".mcap") {
    throw Failure({ErrorCode::kUsage, "no such output: give a file that ends in .mcap", file.string()});
  }
  arguments.recording = file;
}

SampleType sample_type(const std::string& name) {
  if (const auto type = sample_type_named(name)) return *type;
  throw py::value_error(fmt::format("type: expected one of {}, got '{}'", fmt::join(kSampleTypeNames, ", "), name));
}

ByteOrder byte_order(const std::string& name) {
  if (name == "little") return ByteOrder::kLittle;
  if (name == "big") return ByteOrder::kBig;
  throw py::value_error(fmt::format("byte_order: expected 'little' or 'big', got '{}'", name));
}

/// One length for all axes, or one for each.
Eigen::Vector3d spacing_mm(const std::variant<double, std::array<double, 3>>& given) {
  const auto* of_all = std::get_if<double>(&given);
  const Eigen::Vector3d spacing =
      of_all != nullptr ? Eigen::Vector3d::Constant(*of_all) : Eigen::Vector3d(std::get<1>(given).data());
  if (spacing.allFinite() && spacing.minCoeff() > 0) return spacing;
  throw py::value_error("spacing_mm: expected finite numbers, above 0");
}

VolumeOptions volume_options(Keywords& keywords) {
  VolumeOptions options;
  std::optional<std::array<int, 3>> dims;
  keywords.read("dims", dims);
  if (dims) options.dims = Eigen::Vector3i(dims->data());
  if (options.dims && options.dims->minCoeff() < 1) throw py::value_error("dims: expected three numbers, above 0");
  std::optional<std::string> type, order;
  keywords.read("type", type);
  keywords.read("byte_order", order);
  if (type) options.type = sample_type(*type);
  if (order) options.byte_order = byte_order(*order);
  std::optional<std::variant<double, std::array<double, 3>>> spacing;
  keywords.read("spacing_mm", spacing);
  if (spacing) options.spacing = spacing_mm(*spacing);
  keywords.read("header_bytes", options.header_bytes);
  return options;
}

}  // namespace

ConfigSources config_sources(Keywords& keywords) {
  ConfigSources config;
  keywords.read("presets", config.presets);
  keywords.read("settings", config.assignments);
  return config;
}

RunArguments run_arguments(const Path& recording, const Path& output, Keywords& keywords) {
  RunArguments arguments;
  arguments.recording = recording;
  arguments.outputs = output_request(output, keywords);
  arguments.from = keywords.number<std::size_t>("first", 0, kMostFrames).value_or(arguments.from);
  arguments.to = keywords.number<std::size_t>("last", 0, kMostFrames);
  arguments.every = keywords.number<std::size_t>("every", 1, 1e6).value_or(arguments.every);
  keywords.read("angles", arguments.angles);
  keywords.read("cut_recording", arguments.cut_recording);
  return arguments;
}

CaptureArguments capture_arguments(const Path& output, Keywords& keywords) {
  CaptureArguments arguments;
  arguments.scanner = scanner_request(keywords);
  arguments.outputs = output_request(output, keywords);
  read_recording(keywords, arguments);
  return arguments;
}

AlignArguments align_arguments(std::vector<Path> inputs, const Path& output, Keywords& keywords) {
  if (inputs.empty()) throw py::value_error("inputs: expected at least one scan");
  AlignArguments arguments;
  arguments.request.inputs = std::move(inputs);
  arguments.outputs = output_request(output, keywords);
  keywords.read("initial", arguments.request.known.initial);
  keywords.read("markers", arguments.request.known.markers);
  keywords.read("refine", arguments.request.known.wants_refinement);
  keywords.read("points", arguments.request.points);
  return arguments;
}

ExtractArguments extract_arguments(const Path& volume, const Path& output, Keywords& keywords, ConfigSources& config) {
  ExtractArguments arguments;
  arguments.volume = volume;
  arguments.outputs.output = output;
  arguments.options = volume_options(keywords);
  std::optional<std::variant<double, std::string>> isovalue;
  keywords.read("isovalue", isovalue);
  if (!isovalue) return arguments;
  if (const auto* number = std::get_if<double>(&*isovalue)) {
    config.assignments.push_back(fmt::format("extract.isovalue={}", *number));
    return arguments;
  }
  arguments.wants_auto_isovalue = true;
  if (const auto& word = std::get<std::string>(*isovalue); word != "auto") {
    throw py::value_error(fmt::format("isovalue: expected a number, 'auto' or None, got '{}'", word));
  }
  return arguments;
}

}  // namespace scanknit
