#include "core/module.h"

#include <dlfcn.h>

#include <filesystem>
#include <string_view>

#include "core/version.h"

namespace scanknit {
namespace {

/// `file` alone, for the loader to look for, where it is in none of our folders.
std::filesystem::path module_path(const std::string& file) {
  ::Dl_info here{};
  if (::dladdr(reinterpret_cast<const void*>(&open_module), &here) == 0 || here.dli_fname == nullptr) return file;
  const std::filesystem::path folder = std::filesystem::path(here.dli_fname).parent_path();
  for (const char* beside : {"scanknit", ".", "../" SCANKNIT_LIBDIR "/scanknit", "../lib"}) {
    std::error_code ignored;
    if (auto path = folder / beside / file; std::filesystem::is_regular_file(path, ignored)) return path;
  }
  return file;
}

}  // namespace

Result<const void*> open_module(const std::string& name, const std::string& remedy) {
  const std::string file = "libscanknit_" + name + ".so";
  const auto refuse = [&](const std::string& why) {
    return Error{ErrorCode::kInternal, "the module " + file + " cannot be used: " + why + ". " + remedy};
  };
  // What it gives points into it, so that it is never unloaded.
  void* module = ::dlopen(module_path(file).c_str(), RTLD_NOW | RTLD_LOCAL | RTLD_NODELETE);
  if (module == nullptr) return refuse(::dlerror());
  const auto entry_of = reinterpret_cast<const ModuleEntry* (*)()>(::dlsym(module, "scanknit_module"));
  const ModuleEntry* entry = entry_of == nullptr ? nullptr : entry_of();
  if (entry == nullptr || std::string_view(entry->version) != kVersion) {
    return refuse("it is of another version of ScanKnit");
  }
  return entry->offers;
}

}  // namespace scanknit
