#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "app/calibrate/calibrate_arguments.h"
#include "app/calibrate/target_file.h"
#include "app/exit_codes.h"
#include "core/files/atomic_file.h"
#include "core/files/quantity.h"

namespace scanknit {
namespace {

/// The size that was asked for, else the largest that fits.
Result<CalibrationTarget> sized(const CalibrateTargetArguments& arguments) {
  const bool is_grid = arguments.type == TargetType::kAprilGrid;
  CalibrationTarget target{arguments.type, arguments.columns.value_or(is_grid ? 6 : 9),
                           arguments.rows.value_or(is_grid ? 4 : 6), arguments.size_m.value_or(0.01)};
  if (auto valid = validate(target); !valid) return Error{ErrorCode::kUsage, valid.error().message};
  if (arguments.size_m) return target;
  const auto largest = largest_size_m(target, arguments.paper);
  if (!largest) {
    return Error{ErrorCode::kUsage, "so many columns and rows do not fit on the paper; take fewer, or larger paper"};
  }
  target.size_m = *largest;
  return target;
}

}  // namespace

int calibrate_target_command(const CalibrateTargetArguments& arguments, const CommonArguments& common) {
  const auto target = sized(arguments);
  if (!target) return fail(target.error(), common);
  const auto page = target_page(*target, arguments.paper);
  if (!page) return fail(page.error(), common);
  const std::filesystem::path& output = arguments.output;
  std::filesystem::path description = output;
  description.replace_extension(".yaml");
  const bool is_svg = output.extension() == ".svg";
  if (auto done = write_file_atomically(output, is_svg ? svg_of(*page) : pdf_of(*page)); !done) {
    return fail(done.error(), common);
  }
  if (auto done = write_file_atomically(description, target_file_text(*target)); !done) {
    return fail(done.error(), common);
  }
  if (common.is_json) {
    const nlohmann::ordered_json json = {{"output", output.string()},
                                         {"target", description.string()},
                                         {"size_m", target->size_m},
                                         {"corners", target_corners(*target).size()}};
    return print_result(json.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n", common);
  }
  if (common.verbosity == Verbosity::kQuiet) return kExitOk;
  return print_result(
      fmt::format("Written  {}: {} x {}, {}; {}\n"
                  "Next     print it in actual size (100 %), measure its two lines of 100 mm, glue it to a "
                  "flat plate,\n"
                  "         record it from all sides, then scanknit calibrate camera RECORDING --target {} "
                  "-o CAMERA.yaml\n",
                  output.string(), target->columns, target->rows, format_length(target->size_m), description.string(),
                  description.string()),
      common);
}

}  // namespace scanknit
