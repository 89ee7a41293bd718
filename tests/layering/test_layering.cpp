// The house rules of docs/architecture.md, read off the #include lines.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <map>
#include <regex>
#include <set>
#include <string>
#include <vector>

namespace {

namespace fs = std::filesystem;

struct Include {
  std::string file;  // relative to the source root
  std::string room;  // its first folder
  bool is_header;
  std::string target;
  bool is_quoted;
};

const std::set<std::string> kRooms = {"core",   "acquire", "synth", "fusion", "extract", "finish",
                                      "export", "scan",    "view",  "app",    "python"};

/// Which rooms a room may include beside itself and core. app and python join all of them.
const std::map<std::string, std::set<std::string>> kMayInclude = {
    {"core", {}},   {"acquire", {}}, {"synth", {"acquire"}},
    {"fusion", {}}, {"extract", {}}, {"finish", {}},
    {"export", {}}, {"view", {}},    {"scan", {"acquire", "fusion", "extract", "finish", "export"}},
};

std::vector<Include> all_includes() {
  const std::regex pattern(R"(^\s*#\s*include\s*([<"])([^>"]+)[>"])");
  std::vector<Include> includes;
  for (const std::string& room : kRooms) {
    for (const auto& entry : fs::recursive_directory_iterator(fs::path(SCANKNIT_SOURCE_DIR) / room)) {
      const auto extension = entry.path().extension();
      if (extension != ".h" && extension != ".cpp") continue;
      std::ifstream file(entry.path());
      for (std::string line; std::getline(file, line);) {
        std::smatch match;
        if (!std::regex_search(line, match, pattern)) continue;
        includes.push_back({fs::relative(entry.path(), SCANKNIT_SOURCE_DIR).string(), room, extension == ".h",
                            match[2].str(), match[1].str() == "\""});
      }
    }
  }
  return includes;
}

std::string first_folder(const std::string& target) {
  return target.substr(0, target.find('/'));
}

TEST(Layering, FindsTheSources) {
  EXPECT_GT(all_includes().size(), 100u);
}

TEST(Layering, RoomsIncludeOnlyWhatLiesBelowThem) {
  for (const Include& include : all_includes()) {
    if (include.room == "app" || include.room == "python" || !include.is_quoted) continue;
    const std::string room = first_folder(include.target);
    const auto& [floor, allowed] = *kMayInclude.find(include.room);
    const bool is_allowed = room == floor || room == "core" || allowed.count(room) > 0;
    EXPECT_TRUE(is_allowed) << include.file << " includes " << include.target;
  }
}

TEST(Layering, OurHeadersAreNamedFromTheRoot) {
  for (const Include& include : all_includes()) {
    if (!include.is_quoted) continue;
    EXPECT_TRUE(kRooms.count(first_folder(include.target))) << include.file << " includes \"" << include.target << "\"";
  }
}

/// Where each library lives: the rooms, or the single files, that may name it.
const std::map<std::string, std::set<std::string>> kHomes = {
    {"opencv2", {"acquire", "fusion", "extract", "export"}},
    {"pcl", {"acquire", "fusion", "finish"}},
    {"openvdb", {"core/field_view.h", "fusion", "extract", "finish", "scan", "app"}},
    {"boost", {"extract", "view"}},
    {"qrcodegen", {"view"}},
    {"hwy", {"acquire", "fusion", "extract"}},
    {"meshoptimizer.h", {"export", "finish"}},
    {"zlib.h", {"core", "acquire", "extract", "export"}},
    {"gdcmReader.h", {"extract"}},
    {"NrrdIO.h", {"extract"}},
    {"tiny_gltf.h", {"export"}},
    {"kainjow", {"export"}},
    {"nlohmann", {"acquire", "synth", "export", "view", "app"}},
    {"yaml-cpp", {"app"}},
    {"CLI", {"app"}},
    {"pybind11", {"python"}},
    {"spdlog", {"app"}},
    {"libusb-1.0", {"acquire"}},
    {"libfreenect.h", {"acquire"}},
    {"OniCAPI.h", {"acquire"}},
    {"zstd.h", {"acquire"}},
    {"lz4frame.h", {"acquire"}},
    {"bzlib.h", {"acquire"}},
};

// All rooms share one namespace: two types of one name would be one to the linker.
TEST(Layering, NoTwoHeadersDefineATypeOfOneName) {
  const std::regex definition(R"(^(?:class|struct|enum class) (?:alignas\(\d+\) )?(\w+)(?: final)?(?: :.*)?\s*\{)");
  std::map<std::string, std::string> first;
  for (const std::string& room : kRooms) {
    for (const auto& entry : fs::recursive_directory_iterator(fs::path(SCANKNIT_SOURCE_DIR) / room)) {
      if (entry.path().extension() != ".h") continue;
      std::ifstream file(entry.path());
      for (std::string line; std::getline(file, line);) {
        std::smatch match;
        if (!std::regex_search(line, match, definition)) continue;
        const auto [place, is_new] = first.emplace(match[1].str(), entry.path().string());
        EXPECT_TRUE(is_new) << match[1] << " in " << entry.path() << " and " << place->second;
      }
    }
  }
  EXPECT_GT(first.size(), 100u);
}

TEST(Layering, LibrariesStayInTheirHome) {
  for (const Include& include : all_includes()) {
    if (include.is_quoted) continue;
    const auto home = kHomes.find(first_folder(include.target));
    if (home == kHomes.end()) continue;
    EXPECT_TRUE(home->second.count(include.room) || home->second.count(include.file))
        << include.file << " includes <" << include.target << ">";
  }
}

/// Headers that are not installed (cmake/Install.cmake) may name the libraries of their room.
const std::set<std::string> kPrivateHeaders = {"export/report/page_json.h"};

TEST(Layering, HeadersNameNoLibraryButEigenAndOpenVdb) {
  for (const Include& include : all_includes()) {
    if (kPrivateHeaders.count(include.file)) continue;
    if (include.is_quoted || !include.is_header || include.room == "app" || include.room == "python") continue;
    const std::string library = first_folder(include.target);
    if (library == "openvdb") continue;  // part of the interface of fusion, extract and finish
    EXPECT_FALSE(kHomes.count(library)) << include.file << " includes <" << include.target << ">";
  }
}

}  // namespace
