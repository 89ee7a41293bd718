// SqliteFile: the tables of an SQLite database, read row by row (sqlite.org, "Database File Format").
// SQLite itself refuses a file that is cut off, and runs what a hostile schema says. This reads tables alone, from
// front to back, and as far as the file is whole.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "acquire/mcap/random_access.h"
#include "core/limits.h"
#include "core/result.h"

namespace scanknit {

/// Where the bytes of a row are: the first in its page, the rest in a chain of pages.
struct SqlitePlace {
  std::uint64_t begin = 0;     ///< of the first part, in the file
  std::uint32_t local = 0;     ///< its length
  std::uint32_t overflow = 0;  ///< the page that goes on; 0: none
  std::uint64_t size = 0;      ///< of the row
};

struct SqliteColumn {
  enum class Kind { kNull, kInteger, kReal, kBlob, kText };
  Kind kind = Kind::kNull;
  std::uint64_t offset = 0, length = 0;  ///< in the row's bytes
  std::int64_t integer = 0;              ///< of kInteger
};

struct SqliteRow {
  std::int64_t id = 0;  ///< also the value of a column INTEGER PRIMARY KEY, which is kNull itself
  SqlitePlace place;
  std::vector<SqliteColumn> columns;
};

struct SqliteTable {
  std::uint32_t root = 0;
  std::vector<std::string> columns;  ///< their names

  [[nodiscard]] std::optional<std::size_t> column(std::string_view name) const;
};

/// True when the file begins as a database does.
[[nodiscard]] bool is_sqlite(const RandomAccess& file);

/// Not thread-safe. The file may be truncated or damaged: every row that is whole is found.
class SqliteFile {
 public:
  /// Errors (kInput, without `where`): no database of SQLite 3; one whose texts are not UTF-8.
  [[nodiscard]] static Result<SqliteFile> open(std::unique_ptr<RandomAccess> file);

  /// Nothing: there is no such table.
  [[nodiscard]] std::optional<SqliteTable> find_table(std::string_view name);

  /// Calls `visit` for each row, in the order of their numbers, until it returns false.
  template <typename Visit>
  void visit_rows(std::uint32_t root, Visit visit) {
    std::vector<Step> path;
    std::vector<bool> is_visited(static_cast<std::size_t>(pages_) + 1);  // by page: a damaged tree may be a circle
    if (!enter(root, path, is_visited)) return;
    SqliteRow row;
    while (next_row(path, is_visited, row)) {
      if (!visit(row)) return;
    }
  }

  /// Fills `to` with bytes of a row from `offset` on; false: they are not there.
  [[nodiscard]] bool read(const SqlitePlace& place, std::uint64_t offset, std::span<std::byte> to) const;

  /// A column's text; nothing: it has none, or one of more than 64 KiB.
  [[nodiscard]] std::optional<std::string> text(const SqliteRow& row, std::size_t column) const;

  /// What is missing or damaged, as text; nothing: nothing was met so far.
  [[nodiscard]] const std::optional<std::string>& fault() const { return fault_; }

 private:
  /// A page on the way from the root to a leaf, and the next of its cells.
  struct Step {
    std::vector<std::byte> page;
    std::uint32_t number = 0;
    std::size_t head = 0;   // where its header begins
    std::size_t cells = 0;  // and for inner pages one more, the right-most child
    std::size_t next = 0;
    bool is_leaf = false;
    std::optional<std::int64_t> last_id = {};  // of a leaf, where numbers ascend
  };

  explicit SqliteFile(std::unique_ptr<RandomAccess> file) : file_(std::move(file)) {}
  [[nodiscard]] std::uint64_t page_begin(std::uint32_t number) const { return std::uint64_t{number - 1} * page_size_; }
  [[nodiscard]] bool enter(std::uint32_t number, std::vector<Step>& path, std::vector<bool>& is_visited);
  [[nodiscard]] bool next_row(std::vector<Step>& path, std::vector<bool>& is_visited, SqliteRow& row);
  [[nodiscard]] std::optional<std::uint32_t> child_of(Step& step) const;
  [[nodiscard]] bool parse_cell(const Step& step, std::size_t at, SqliteRow& row) const;
  [[nodiscard]] bool parse_columns(SqliteRow& row) const;
  void note_fault(std::uint32_t page);

  std::unique_ptr<RandomAccess> file_;
  std::uint32_t page_size_ = 0;
  std::uint32_t usable_ = 0;  // bytes of a page
  std::uint64_t pages_ = 0;
  std::optional<std::string> fault_;
};

}  // namespace scanknit
