// report: draws report.html of a run again.
#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <system_error>

#include "app/commands.h"
#include "core/files/located.h"
#include "core/files/read_file.h"
#include "core/limits.h"
#include "export/report/report_page.h"

namespace scanknit {
namespace {

namespace fs = std::filesystem;

/// The paths of a report and of its page. The pictures are next to the page.
struct ReportPlace {
  fs::path json, page;
};

Result<ReportPlace> find_report(const ReportArguments& arguments) {
  const fs::path& place = arguments.place;
  std::error_code ignored;
  if (fs::is_directory(place, ignored)) {
    const fs::path json = arguments.report.value_or(place / "report.json");
    if (arguments.report || fs::exists(json, ignored)) return ReportPlace{json, place / "report.html"};
    return Error{ErrorCode::kInput,
                 "no such file; if the run wrote it elsewhere, say where: scanknit report OUT --report FILE",
                 json.string()};
  }
  if (fs::is_regular_file(place, ignored) && !arguments.report) {
    ReportPlace found{place, fs::path(place).replace_extension(".html")};
    if (found.page != place) return found;
  }
  return Error{ErrorCode::kInput,
               "expected a folder with report.json, as `scanknit run ... -o OUT` writes it, or a report.json",
               place.string()};
}

}  // namespace

int report_command(const ReportArguments& arguments, const CommonArguments& common) {
  const auto found = find_report(arguments);
  if (!found) return fail(found.error(), common);
  const auto json = read_text_file(found->json, Limits{}.max_text_bytes);
  if (!json) return fail(json.error(), common);
  if (auto sound = check_report(*json); !sound) return fail(located(sound.error(), found->json), common);
  if (auto written = write_report_page(*json, found->page); !written) {
    return fail(located(written.error(), found->json), common);
  }
  const std::string page = found->page.string();
  const nlohmann::json result = {{"page", page}};
  constexpr auto kRepaired = nlohmann::json::error_handler_t::replace;
  return print_result(common.is_json ? result.dump(2, ' ', false, kRepaired) + "\n" : page + "\n", common);
}

}  // namespace scanknit
