#include <fmt/format.h>

#include "app/commands.h"
#include "app/config/config_print.h"
#include "app/exit_codes.h"

namespace scanknit {

int config_print_command(const ConfigArguments& arguments, const CommonArguments& common) {
  const auto loaded = read_config(arguments.built_in ? common.config : with_run_defaults(common.config));
  if (!loaded) return fail(loaded.error(), common);
  return print_result(common.is_json ? config_to_json(loaded->config) + "\n" : config_to_yaml(loaded->config), common);
}

int config_check_command(const ConfigArguments& arguments, const CommonArguments& common) {
  ConfigSources sources = with_run_defaults(common.config);
  sources.file = arguments.file;
  const auto loaded = read_config(sources);
  if (!loaded) return fail(loaded.error(), common);
  return print_result(arguments.file.string() + ": ok\n", common);
}

int config_schema_command() {
  return print_result(config_json_schema(), CommonArguments{});
}

int config_docs_command() {
  const auto run_defaults = read_config(with_run_defaults({}));
  if (!run_defaults) return fail(run_defaults.error(), {});
  return print_result(config_markdown(run_defaults->config), CommonArguments{});
}

}  // namespace scanknit
