// report: the page of a run, drawn again.
#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <system_error>

#include "app/commands.h"
#include "core/limits.h"
#include "core/read_file.h"
#include "export/report_page.h"

namespace scanknit {

int report_command(const ReportArguments& arguments, const CommonArguments& common) {
  const std::filesystem::path& folder = arguments.folder;
  std::error_code ignored;
  if (!std::filesystem::is_directory(folder, ignored)) {
    return fail({ErrorCode::kInput, "expected a folder with report.json, as `scanknit run ... -o OUT` writes it",
                 folder.string()},
                common);
  }
  const auto json = read_text_file(folder / "report.json", Limits{}.max_text_bytes);
  if (!json) return fail(json.error(), common);
  const std::filesystem::path page = folder / "report.html";
  if (auto written = write_report_page(*json, page); !written) {
    Error error = written.error();
    if (error.where.empty()) error.where = (folder / "report.json").string();
    return fail(error, common);
  }
  const nlohmann::json result = {{"page", page.string()}};
  constexpr auto kRepaired = nlohmann::json::error_handler_t::replace;
  return print_result(common.is_json ? result.dump(2, ' ', false, kRepaired) + "\n" : page.string() + "\n", common);
}

}  // namespace scanknit
