#include "core/module.h"

#include <dlfcn.h>
#include <link.h>

#include <filesystem>
#include <string_view>

#include "core/version.h"

namespace scanknit {
namespace {

/// The file that this code is in: libscanknit_core.so; in a static build the program, or a module.
std::filesystem::path own_file() {
  ::Dl_info here{};
  ::link_map* object = nullptr;
  const auto found =
      ::dladdr1(reinterpret_cast<const void*>(&open_module), &here, reinterpret_cast<void**>(&object), RTLD_DL_LINKMAP);
  if (found != 0 && *object->l_name != '\0') return object->l_name;
  std::error_code ignored;  // the loader has no name for the program itself
  return std::filesystem::read_symlink("/proc/self/exe", ignored);
}

/// `file` alone, for the loader to look for, where it is in none of our folders.
std::filesystem::path module_path(const std::string& file) {
  const std::filesystem::path folder = own_file().parent_path();
  if (folder.empty()) return file;
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
  // What it gives points into it, so that it is never unloaded. Functions are bound when they are called, as the
  // program's own are: the tens of thousands that its libraries have among each other would take a moment.
  void* module = ::dlopen(module_path(file).c_str(), RTLD_LAZY | RTLD_LOCAL | RTLD_NODELETE);
  if (module == nullptr) return refuse(::dlerror());
  const auto entry_of = reinterpret_cast<const ModuleEntry* (*)()>(::dlsym(module, "scanknit_module"));
  const ModuleEntry* entry = entry_of == nullptr ? nullptr : entry_of();
  if (entry == nullptr || std::string_view(entry->version) != kVersion) {
    return refuse("it is of another version of ScanKnit");
  }
  return entry->offers;
}

}  // namespace scanknit
