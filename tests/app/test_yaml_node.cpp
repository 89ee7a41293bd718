#include <gtest/gtest.h>

#include <string>

#include "app/config/yaml_node.h"

namespace scanknit {
namespace {

YamlError error_of(const std::string& text) {
  const auto parsed = parse_yaml(text);
  const auto* error = std::get_if<YamlError>(&parsed);
  EXPECT_NE(error, nullptr) << text;
  return error ? *error : YamlError{0, 0, ""};
}

TEST(Yaml, KeepsRepeatedKeysAndTheirPlaces) {
  const auto parsed = parse_yaml("a: 1\nb: 2\na: 3\n");
  const auto& root = std::get<YamlNode>(parsed);
  ASSERT_EQ(root.children.size(), 6u);
  EXPECT_EQ(root.children[4].text, "a");
  EXPECT_EQ(root.children[4].line, 3);
  EXPECT_EQ(root.children[5].text, "3");
  EXPECT_EQ(root.children[5].column, 4);
}

TEST(Yaml, AnEmptyTextIsNull) {
  EXPECT_EQ(std::get<YamlNode>(parse_yaml("")).kind, YamlNode::Kind::kNull);
  EXPECT_EQ(std::get<YamlNode>(parse_yaml("# nothing\n")).kind, YamlNode::Kind::kNull);
}

TEST(Yaml, RefusesAliasesBeforeTheyUnfold) {
  const YamlError error = error_of("a: &x [1, 2]\nb: [*x, *x]\n");
  EXPECT_EQ(error.line, 1);
  EXPECT_NE(error.message.find("anchors"), std::string::npos);
}

TEST(Yaml, RefusesDeepNesting) {
  const std::string deep = std::string(5'000, '[') + std::string(5'000, ']');
  EXPECT_NE(error_of(deep).message.find("16 levels"), std::string::npos);
}

TEST(Yaml, PointsAtTheTabThatIndentsALine) {
  const YamlError error = error_of("fusion:\n\tvoxel_size: 2mm\n");
  EXPECT_EQ(error.line, 2);
  EXPECT_EQ(error.column, 1);
  EXPECT_NE(error.message.find("tab"), std::string::npos);
}

TEST(Yaml, RefusesASecondDocument) {
  EXPECT_NE(error_of("a: 1\n---\nb: 2\n").message.find("second document"), std::string::npos);
}

TEST(Yaml, RefusesZeroBytes) {
  EXPECT_NE(error_of(std::string("a: 1\n\0b", 7)).message.find("zero byte"), std::string::npos);
}

TEST(Yaml, EveryTruncationOfADocumentIsReadOrRefusedWithoutHarm) {
  const std::string text = "acquire: {intrinsics: [1, 2, \"3\", '4']}\nfusion:\n  noise: {floor: 1 mm}\n- x\n";
  for (std::size_t length = 0; length <= text.size(); ++length) (void)parse_yaml(text.substr(0, length));
}

}  // namespace
}  // namespace scanknit
