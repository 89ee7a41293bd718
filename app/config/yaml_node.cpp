#include "app/config/yaml_node.h"

#include <yaml-cpp/eventhandler.h>
#include <yaml-cpp/exceptions.h>
#include <yaml-cpp/parser.h>

#include <exception>
#include <optional>
#include <sstream>
#include <utility>

namespace scanknit {
namespace {

constexpr std::size_t kMaxDepth = 16;  // the configuration has three levels

/// Builds the tree from yaml-cpp's events. YAML::Node would resolve aliases and drop repeated keys.
class TreeBuilder final : public YAML::EventHandler {
 public:
  [[nodiscard]] YamlNode take_root() { return std::move(root_); }

  void OnDocumentStart(const YAML::Mark&) override {}
  void OnDocumentEnd() override {}
  void OnNull(const YAML::Mark& mark, YAML::anchor_t anchor) override {
    add(begin(YamlNode::Kind::kNull, mark, anchor));
  }
  void OnAlias(const YAML::Mark& mark, YAML::anchor_t) override {
    throw YAML::ParserException(mark, "aliases (*name) are not allowed here");
  }
  void OnScalar(const YAML::Mark& mark, const std::string&, YAML::anchor_t anchor, const std::string& text) override {
    YamlNode node = begin(YamlNode::Kind::kScalar, mark, anchor);
    node.text = text;
    add(std::move(node));
  }
  void OnSequenceStart(const YAML::Mark& mark, const std::string&, YAML::anchor_t anchor,
                       YAML::EmitterStyle::value) override {
    open_.push_back(begin(YamlNode::Kind::kSequence, mark, anchor));
  }
  void OnSequenceEnd() override { close(); }
  void OnMapStart(const YAML::Mark& mark, const std::string&, YAML::anchor_t anchor,
                  YAML::EmitterStyle::value) override {
    open_.push_back(begin(YamlNode::Kind::kMap, mark, anchor));
  }
  void OnMapEnd() override { close(); }

 private:
  [[nodiscard]] YamlNode begin(YamlNode::Kind kind, const YAML::Mark& mark, YAML::anchor_t anchor) const {
    if (anchor != 0) throw YAML::ParserException(mark, "anchors (&name) are not allowed here");
    if (open_.size() >= kMaxDepth) throw YAML::ParserException(mark, "nested deeper than 16 levels");
    YamlNode node;
    node.kind = kind;
    node.line = mark.line + 1;  // yaml-cpp counts from 0
    node.column = mark.column + 1;
    return node;
  }
  void add(YamlNode node) { (open_.empty() ? root_ : open_.back().children.emplace_back()) = std::move(node); }
  void close() {
    YamlNode node = std::move(open_.back());
    open_.pop_back();
    add(std::move(node));
  }

  std::vector<YamlNode> open_;
  YamlNode root_;
};

/// Finds the first line that is indented by a tab. yaml-cpp reports another line for it, with an unclear message.
std::optional<YamlError> find_tab_indent(std::string_view text) {
  int line = 1;
  while (!text.empty()) {
    const std::size_t end = text.find('\n');
    const std::string_view current = text.substr(0, end);
    const std::size_t first = current.find_first_not_of(' ');
    if (first != std::string_view::npos && current[first] == '\t') {
      return YamlError{line, static_cast<int>(first) + 1, "indented by a tab; YAML wants spaces"};
    }
    if (end == std::string_view::npos) break;
    text.remove_prefix(end + 1);
    ++line;
  }
  return std::nullopt;
}

}  // namespace

std::variant<YamlNode, YamlError> parse_yaml(std::string_view text) {
  if (const std::size_t nul = text.find('\0'); nul != std::string_view::npos) {
    return YamlError{1, 1, "holds a zero byte: this is no text file"};
  }
  try {
    std::istringstream stream{std::string(text)};
    YAML::Parser parser(stream);
    TreeBuilder builder;
    if (!parser.HandleNextDocument(builder)) return YamlNode{};
    YamlNode root = builder.take_root();
    TreeBuilder second;
    if (parser.HandleNextDocument(second)) {
      const YamlNode extra = second.take_root();
      return YamlError{extra.line, extra.column, "a second document; one is expected"};
    }
    return root;
  } catch (const YAML::Exception& exception) {
    if (auto tab = find_tab_indent(text)) return *tab;
    const bool has_place = !exception.mark.is_null();
    return YamlError{has_place ? exception.mark.line + 1 : 1, has_place ? exception.mark.column + 1 : 1, exception.msg};
  } catch (const std::exception& exception) {
    return YamlError{1, 1, exception.what()};
  }
}

}  // namespace scanknit
