// The house rules of docs/architecture.md, read off the #include lines.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>
#include <optional>
#include <regex>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "tests/support/places.h"

namespace {

namespace fs = std::filesystem;

struct Include {
  std::string file;  // relative to the source root
  std::string room;  // its first folder
  bool is_header;
  std::string target;
  bool is_quoted;
};

const std::set<std::string> kRooms = {"core",   "acquire", "calibrate", "synth", "fusion", "extract", "finish",
                                      "export", "scan",    "view",      "app",   "python", "measure"};

/// Which rooms a room may include beside itself and core. app and python join all of them.
const std::map<std::string, std::set<std::string>> kMayInclude = {
    {"core", {}},
    {"acquire", {}},
    {"calibrate", {"acquire"}},
    {"measure", {}},
    {"synth", {"acquire", "calibrate", "measure"}},
    {"fusion", {}},
    {"extract", {}},
    {"finish", {}},
    {"export", {}},
    {"view", {}},
    {"scan", {"acquire", "fusion", "extract", "finish", "export"}},
};

/// What a line includes, and whether in quotes; nothing if the line is no #include.
std::optional<std::pair<std::string, bool>> included_by(const std::string& line) {
  static const std::regex pattern(R"(^\s*#\s*include\s*([<"])([^>"]+)[>"])");
  std::smatch match;
  if (!std::regex_search(line, match, pattern)) return std::nullopt;
  return std::pair(match[2].str(), match[1].str() == "\"");
}

std::vector<Include> all_includes() {
  std::vector<Include> includes;
  for (const std::string& room : kRooms) {
    for (const auto& entry : fs::recursive_directory_iterator(fs::path(scanknit::test::kSourceDir) / room)) {
      const auto extension = entry.path().extension();
      if (extension != ".h" && extension != ".cpp" && extension != ".inl") continue;
      std::ifstream file(entry.path());
      for (std::string line; std::getline(file, line);) {
        const auto included = included_by(line);
        if (!included) continue;
        includes.push_back({fs::relative(entry.path(), scanknit::test::kSourceDir).string(), room, extension == ".h",
                            included->first, included->second});
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

/// True for the header of a room, in quotes or in angle brackets.
bool is_of_a_room(const Include& include) {
  return include.target.find('/') != std::string::npos && kRooms.contains(first_folder(include.target));
}

/// False if the room of the file may not include the room of what it includes.
bool is_allowed(const Include& include) {
  if (include.room == "app" || include.room == "python" || !is_of_a_room(include)) return true;
  const std::string room = first_folder(include.target);
  return room == include.room || room == "core" || kMayInclude.at(include.room).contains(room);
}

/// A room's header is named in quotes, from the root; all others in angle brackets.
bool is_named_rightly(const Include& include) {
  return include.is_quoted == is_of_a_room(include);
}

TEST(Layering, RoomsIncludeOnlyWhatLiesBelowThem) {
  for (const Include& include : all_includes()) {
    EXPECT_TRUE(is_allowed(include)) << include.file << " includes " << include.target;
  }
}

TEST(Layering, OurHeadersAreNamedFromTheRootAndInQuotes) {
  for (const Include& include : all_includes()) {
    EXPECT_TRUE(is_named_rightly(include)) << include.file << " includes " << include.target;
  }
}

using Folders = std::map<std::string, std::set<std::string>>;

/// These choose a format, and GLB has a folder of its own.
const std::set<std::string> kChooseAFormat = {"export/mesh/read_mesh.cpp", "export/mesh/write_mesh.cpp"};

/// The folders that each folder includes, of those within its room. What lies in a room's own folder joins the others.
Folders included_folders(const std::vector<Include>& includes) {
  Folders folders;
  for (const Include& include : includes) {
    const std::string from = fs::path(include.file).parent_path();
    const std::string to = fs::path(include.target).parent_path();
    const bool is_of_a_folder = from != include.room && to.starts_with(include.room + '/');
    if (is_of_a_folder && from != to && !kChooseAFormat.contains(include.file)) folders[from].insert(to);
  }
  return folders;
}

/// True if `from` includes `to`, or a folder that does, and so on.
bool leads_to(const Folders& folders, const std::string& from, const std::string& to, std::set<std::string>& seen) {
  const auto included = folders.find(from);
  if (included == folders.end() || !seen.insert(from).second) return false;
  return included->second.contains(to) ||
         std::any_of(included->second.begin(), included->second.end(),
                     [&](const std::string& next) { return leads_to(folders, next, to, seen); });
}

TEST(Layering, FoldersOfARoomIncludeEachOtherInNoCircle) {
  const Folders folders = included_folders(all_includes());
  EXPECT_GT(folders.size(), 20u);
  for (const auto& [folder, included] : folders) {
    std::set<std::string> seen;
    EXPECT_FALSE(leads_to(folders, folder, folder, seen)) << folder;
  }
}

TEST(Layering, CirclesAreFound) {
  const Folders folders = included_folders({{"scan/a/x.cpp", "scan", false, "scan/b/y.h", true},
                                            {"scan/b/y.cpp", "scan", false, "scan/c/z.h", true},
                                            {"scan/c/z.cpp", "scan", false, "scan/a/x.h", true},
                                            {"scan/d/w.cpp", "scan", false, "scan/a/x.h", true}});
  for (const auto& [folder, is_circle] :
       std::map<std::string, bool>{{"scan/a", true}, {"scan/c", true}, {"scan/d", false}}) {
    std::set<std::string> seen;
    EXPECT_EQ(leads_to(folders, folder, folder, seen), is_circle) << folder;
  }
}

TEST(Layering, IncludesAreFoundInEitherSpelling) {
  EXPECT_EQ(included_by("#include <scan/scan.h>"), std::pair(std::string("scan/scan.h"), false));
  EXPECT_EQ(included_by(" # include \"scan/scan.h\"  // why"), std::pair(std::string("scan/scan.h"), true));
  EXPECT_EQ(included_by("// #include <scan/scan.h>"), std::nullopt);
}

TEST(Layering, WhatARoomMayNotIncludeIsFoundInEitherSpelling) {
  for (const bool is_quoted : {true, false}) {
    EXPECT_FALSE(is_allowed({"fusion/a.cpp", "fusion", false, "scan/scan.h", is_quoted}));
    EXPECT_FALSE(is_allowed({"scan/a.cpp", "scan", false, "view/view_scene.h", is_quoted}));
    EXPECT_TRUE(is_allowed({"scan/a.cpp", "scan", false, "fusion/register/icp.h", is_quoted}));
    EXPECT_TRUE(is_allowed({"fusion/a.cpp", "fusion", false, "core/mesh.h", is_quoted}));
    EXPECT_TRUE(is_allowed({"app/a.cpp", "app", false, "view/view_scene.h", is_quoted}));
  }
}

TEST(Layering, WrongSpellingsAreFound) {
  EXPECT_TRUE(is_named_rightly({"fusion/a.cpp", "fusion", false, "core/mesh.h", true}));
  EXPECT_FALSE(is_named_rightly({"fusion/a.cpp", "fusion", false, "core/mesh.h", false}));
  EXPECT_FALSE(is_named_rightly({"core/a.cpp", "core", false, "mesh.h", true}));
  EXPECT_TRUE(is_named_rightly({"core/a.cpp", "core", false, "png.h", false}));
}

/// Where each library lives: the rooms, or the single files, that may name it. Single .cpp files are those of modules.
const std::map<std::string, std::set<std::string>> kHomes = {
    {"opencv2",
     {"acquire/masks/masks_opencv_module.cpp", "acquire/stereo/stereo_opencv_module.cpp",
      "calibrate/board/calibrate_opencv_module.cpp", "fusion/track/features_opencv_module.cpp",
      "extract/volume/image_stack.cpp", "export"}},
    {"pcl",
     {"acquire/pcl/acquire_pcl_module.cpp", "finish/finish_pcl_module.cpp", "fusion/align/align_pcl_module.cpp"}},
    {"openvdb", {"core/field_view.h", "fusion", "extract", "finish", "scan", "app"}},
    {"boost", {"extract", "view"}},
    {"qrcodegen", {"view"}},
    {"hwy", {"core", "acquire", "fusion", "extract"}},
    {"meshoptimizer.h", {"export", "finish"}},
    {"png.h", {"core"}},
    {"jpeglib.h", {"core"}},
    {"zlib.h", {"core", "acquire", "extract", "export"}},
    {"gdcmImageReader.h", {"extract/volume/dicom_series.cpp"}},
    {"gdcmTrace.h", {"extract/volume/dicom_series.cpp"}},
    {"NrrdIO.h", {"extract/volume/itk_headers.cpp"}},
    {"metaImage.h", {"extract/volume/itk_headers.cpp"}},
    {"nifti1_io.h", {"extract/volume/itk_headers.cpp"}},
    {"tiny_gltf.h", {"export/glb/glb_accessor.cpp", "export/glb/glb_reader_module.cpp", "export/glb/glb_texture.cpp"}},
    {"STEPControl_Reader.hxx", {"export/step/step_reader_module.cpp"}},
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

/// All headers of all rooms, .inl files included, by their path from the source root, without comments.
std::map<std::string, std::vector<std::string>> all_headers() {
  std::map<std::string, std::vector<std::string>> headers;
  for (const std::string& room : kRooms) {
    for (const auto& entry : fs::recursive_directory_iterator(fs::path(scanknit::test::kSourceDir) / room)) {
      if (entry.path().extension() != ".h" && entry.path().extension() != ".inl") continue;
      std::vector<std::string>& lines = headers[fs::relative(entry.path(), scanknit::test::kSourceDir).string()];
      std::ifstream file(entry.path());
      for (std::string line; std::getline(file, line);) lines.push_back(line.substr(0, line.find("//")));
    }
  }
  return headers;
}

/// What stands between the brackets of a list, split at the commas that are within no other bracket.
std::vector<std::string> split_list(const std::string& list) {
  std::vector<std::string> parts(1);
  int depth = 0;
  for (const char c : list) {
    if (c == '<' || c == '(' || c == '{') ++depth;
    if (c == '>' || c == ')' || c == '}') --depth;
    if (c == ',' && depth == 0)
      parts.emplace_back();
    else
      parts.back() += c;
  }
  return parts;
}

/// "double x, const Pose& T = {}" without names and default values: "double,const Pose&,".
std::string parameter_types(const std::string& parameters) {
  std::string types;
  if (parameters.empty()) return types;
  for (const std::string& parameter : split_list(parameters)) {
    std::string type = std::regex_replace(parameter, std::regex(R"(\s*=.*$|^\s+)"), "");
    type = std::regex_replace(type, std::regex(R"((.*[\s&*>])\w+\s*$)"), "$1");
    types += std::regex_replace(type, std::regex(R"(\s+$)"), "") + ",";
  }
  return types;
}

/// What a header defines or declares at the start of a line, in the rooms' common namespace: types, constants and
/// variables, and functions with the types of their parameters.
std::set<std::string> names_in(const std::vector<std::string>& lines) {
  const std::string before = R"(^(?:template <.*> )?)";
  const std::regex type(before + R"((?:class|struct|union|enum class|enum) (?:alignas\(\d+\) )?(\w+)[^;(]*\{)");
  const std::regex alias(before + R"(using (\w+) =)");
  const std::regex constant(
      R"(^(?:(?:inline|static|constexpr|constinit|const|extern) )+)"  // at least one of these words
      R"((?:[\w:*&]|<.*>| )+[ *&](\w+)(?:\[.*\])*(?: =|\{|;))");
  const std::regex function(R"(^(?!using |#|return )(?:\[\[nodiscard\]\] )?[\w:<>,*& ]+[ &*](\w+)\((.*))");
  std::set<std::string> names;
  for (std::size_t i = 0; i < lines.size(); ++i) {
    if (lines[i].empty() || lines[i].front() == ' ') continue;
    std::smatch match;
    for (const std::regex* one : {&type, &alias, &constant}) {
      if (std::regex_search(lines[i], match, *one)) names.insert(match[1].str());
    }
    if (lines[i].starts_with("struct ") || !std::regex_search(lines[i], match, function)) continue;
    const std::string name = match[1].str();
    std::string parameters = match[2].str();
    const auto end = [&] {
      int depth = 1;
      for (std::size_t at = 0; at < parameters.size(); ++at) {
        depth += parameters[at] == '(' ? 1 : parameters[at] == ')' ? -1 : 0;
        if (depth == 0) return at;
      }
      return std::string::npos;
    };
    while (end() == std::string::npos && ++i < lines.size()) parameters += " " + lines[i];
    names.insert(name + "(" + parameter_types(parameters.substr(0, end())) + ")");
  }
  return names;
}

// All rooms share one namespace: two definitions of one name would be one to the linker. Functions may be overloaded.
TEST(Layering, NoTwoHeadersDefineTheSameName) {
  std::map<std::string, std::string> first;
  for (const auto& [header, lines] : all_headers()) {
    for (const std::string& name : names_in(lines)) {
      const auto [place, is_new] = first.emplace(name, header);
      EXPECT_TRUE(is_new) << name << " in " << header << " and " << place->second;
    }
  }
  for (const char* known : {"CameraIntrinsics", "Pose", "kBlockCells", "kWhole", "decode_weight(WeightCode,)",
                            "extract_surface(const FieldView&,const ExtractConfig&,)"}) {
    EXPECT_TRUE(first.contains(known)) << known;
  }
}

TEST(Layering, NamesAreFoundByTheirKind) {
  const std::set<std::string> expected = {"Grid",  "Kind",   "Leaf",   "add(std::map<int, int>,const Pose&,)",
                                          "kSide", "kNames", "side()", "kName",
                                          "kUnit", "kCount", "kText",  "kList",
                                          "size()"};
  EXPECT_EQ(names_in({"template <typename T> struct Grid final : Base<T> {", "struct Declared;", "enum class Kind {",
                      "using Leaf = Grid<int>;", "inline constexpr std::array<int, 2> kNames = {1, 2};",
                      "inline constexpr int kSide = 8;", "  int indented = 0;", "void add(std::map<int, int> values,",
                      "         const Pose& T = Pose(1));", "[[nodiscard]] inline int side() {", "  return half(8);",
                      "inline const std::string kName = \"a\";", "static const double kUnit{1};",
                      "const int kCount = 2;", "inline constexpr const char* kText = \"b\";",
                      "static const std::map<int, int> kList;", "inline const int& size() {"}),
            expected);
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

/// They are not installed, and may name the libraries of their room.
const std::set<std::string> kPrivateHeaders = {"acquire/parse/json_numbers.h", "acquire/parse/transforms_json.h",
                                               "export/picture/with_opencv.h", "export/report/page_json.h"};

TEST(Layering, HeadersNameNoLibraryButEigenAndOpenVdb) {
  for (const Include& include : all_includes()) {
    if (kPrivateHeaders.count(include.file)) continue;
    if (include.is_quoted || !include.is_header || include.room == "app" || include.room == "python") continue;
    const std::string library = first_folder(include.target);
    if (library == "openvdb") continue;  // part of the interface of fusion, extract and finish
    EXPECT_FALSE(kHomes.count(library)) << include.file << " includes <" << include.target << ">";
  }
}

/// The headers that are installed: HEADERS of each scanknit_room().
std::set<std::string> installed_headers() {
  std::set<std::string> headers;
  std::ifstream file(scanknit::test::kHeadersFile);
  for (std::string line; std::getline(file, line);) headers.insert(line);
  return headers;
}

/// What an installed header includes that a user does not have, or need not have. The C++ library's headers have
/// neither folder nor ending.
bool is_for_users(const Include& include, const std::set<std::string>& installed) {
  if (include.is_quoted) return installed.contains(include.target);
  const std::string library = first_folder(include.target);
  return library == "Eigen" || library == "openvdb" || include.target.find_first_of("/.") == std::string::npos;
}

TEST(Layering, InstalledHeadersIncludeInstalledOnesEigenAndOpenVdb) {
  const std::set<std::string> installed = installed_headers();
  std::set<std::string> seen;
  for (const Include& include : all_includes()) {
    if (!installed.contains(include.file)) continue;
    seen.insert(include.file);
    EXPECT_TRUE(is_for_users(include, installed)) << include.file << " includes " << include.target;
  }
  EXPECT_GT(seen.size(), installed.size() / 2);
}

TEST(Layering, WhatIsNotForUsersIsFound) {
  const std::set<std::string> installed = {"core/mesh.h"};
  const auto may_include = [&](const char* target, bool is_quoted) {
    return is_for_users({"core/mesh.h", "core", true, target, is_quoted}, installed);
  };
  EXPECT_TRUE(may_include("core/mesh.h", true));
  EXPECT_FALSE(may_include("core/median.h", true));
  EXPECT_TRUE(may_include("vector", false));
  EXPECT_TRUE(may_include("Eigen/Core", false));
  EXPECT_TRUE(may_include("openvdb/openvdb.h", false));
  EXPECT_FALSE(may_include("tbb/task_group.h", false));
  EXPECT_FALSE(may_include("zlib.h", false));
}

std::string text_of(const fs::path& path) {
  std::ifstream file(fs::path(scanknit::test::kSourceDir) / path);
  return {std::istreambuf_iterator<char>(file), {}};
}

/// From the first line that begins with `begin` to the next line that is `end`; empty if there is none.
std::string block_of(const std::string& text, const std::string& begin, const std::string& end) {
  const std::size_t first = text.find("\n" + begin);
  const std::size_t last = first == std::string::npos ? first : text.find("\n" + end + "\n", first);
  return last == std::string::npos ? "" : text.substr(first + 1, last - first + end.size());
}

TEST(Layering, TheDriverOnThePageOfTheArchitectureIsTheDriver) {
  const std::string driver = "Result<void> ScanPass::run() {";
  const std::string source = block_of(text_of("scan/scan_pass.cpp"), driver, "}");
  EXPECT_GT(std::count(source.begin(), source.end(), '\n'), 5);
  EXPECT_EQ(block_of(text_of("docs/architecture.md"), driver, "}"), source);
}

TEST(Layering, BlocksAreFound) {
  const std::string text = "int f();\n\nint f() {\n  return 1;\n}\n\nint g() {\n}\n";
  EXPECT_EQ(block_of(text, "int f() {", "}"), "int f() {\n  return 1;\n}");
  EXPECT_EQ(block_of(text, "int h() {", "}"), "");
  EXPECT_EQ(block_of(text, "int f() {", "```"), "");
}

/// The files of each folder of the rooms.
std::map<std::string, std::size_t> files_by_folder() {
  std::map<std::string, std::size_t> files;
  for (const std::string& room : kRooms) {
    for (const auto& entry : fs::recursive_directory_iterator(fs::path(scanknit::test::kSourceDir) / room)) {
      const fs::path path = fs::relative(entry.path(), scanknit::test::kSourceDir);
      const bool is_of_a_package = path.string().find("node_modules") != std::string::npos;
      if (entry.is_regular_file() && !is_of_a_package) ++files[path.parent_path().string()];
    }
  }
  return files;
}

TEST(Layering, NoFolderHasTooManyFiles) {
  constexpr std::size_t kMostFiles = 25;
  const auto folders = files_by_folder();
  EXPECT_TRUE(folders.contains("core"));
  for (const auto& [folder, files] : folders) EXPECT_LE(files, kMostFiles) << folder << ": divide it by subjects";
}

TEST(Layering, InstalledHeadersAreFewAndOnThePageOfPackages) {
  const std::string page = text_of("docs/packages.md");
  const std::set<std::string> installed = installed_headers();
  for (const std::string& header : installed) {
    EXPECT_NE(page.find("`" + header + "`"), std::string::npos) << header;
  }
  const std::regex named("`([a-z_0-9/]+/[a-z_0-9]+\\.h)`");
  for (std::sregex_iterator match(page.begin(), page.end(), named), end; match != end; ++match) {
    EXPECT_TRUE(installed.contains((*match)[1].str())) << (*match)[1].str() << " is not installed";
  }
  EXPECT_LE(installed.size(), 40u);
}

}  // namespace
