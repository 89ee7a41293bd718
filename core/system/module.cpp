#include "core/system/module.h"

#include <dlfcn.h>
#include <link.h>

#include <filesystem>
#include <string_view>

#include "core/version.h"

namespace scanknit {
namespace {

/// Of the library that this is part of; of the program where that is static.
std::filesystem::path own_folder() {
  ::Dl_info here{};
  void* object = nullptr;
  const void* this_function = reinterpret_cast<const void*>(&open_module);
  if (::dladdr1(this_function, &here, &object, RTLD_DL_LINKMAP) == 0) return {};
  const std::string_view library = static_cast<const ::link_map*>(object)->l_name;
  if (!library.empty()) return std::filesystem::path(library).parent_path();
  std::error_code ignored;  // the program is the one that has no name there
  return std::filesystem::read_symlink("/proc/self/exe", ignored).parent_path();
}

/// `file` alone, for the loader to look for, where it is in none of our folders.
std::filesystem::path module_path(const std::string& file) {
  const std::filesystem::path folder = own_folder();
  for (const char* beside : {"scanknit", ".", "../" SCANKNIT_LIBDIR "/scanknit", "../lib"}) {
    std::error_code ignored;
    auto path = folder / beside / file;
    if (!folder.empty() && std::filesystem::is_regular_file(path, ignored)) return path;
  }
  return file;
}

}  // namespace

Result<const void*> open_module(const std::string& name, const std::string& remedy) {
  const std::string file = "libscanknit_" + name + ".so";
  const auto refuse = [&](const std::string& why) {
    return Error{ErrorCode::kInternal, "the module " + file + " cannot be used: " + why + ". " + remedy};
  };
  // What it gives points into it, so that it is never unloaded. A symbol that is missing is an error here, not the end
  // of the program when it is first called.
  void* module = ::dlopen(module_path(file).c_str(), RTLD_NOW | RTLD_LOCAL | RTLD_NODELETE);
  if (module == nullptr) return refuse(::dlerror());
  const auto entry_of = reinterpret_cast<const ModuleEntry* (*)()>(::dlsym(module, "scanknit_module"));
  if (entry_of == nullptr) return refuse("it is no module of ScanKnit");
  const ModuleEntry& entry = *entry_of();
  if (std::string_view(entry.version) != kVersion) {
    return refuse(std::string("it is of ScanKnit ") + entry.version + ", not of " + kVersion);
  }
  return entry.offers;
}

}  // namespace scanknit
