#include "tests/extract/trilinear_truth.h"

#include <algorithm>
#include <numeric>
#include <utility>
#include <vector>

#include "core/check.h"

namespace scanknit::test {
namespace {

__extension__ using Wide = __int128;

/// a + b e + c e^2 for a positive infinitesimal e. Degree 2 is enough: a product of higher degree is never formed.
struct Germ {
  Wide a = 0;
  Wide b = 0;
  Wide c = 0;

  friend Germ operator+(const Germ& p, const Germ& q) { return {p.a + q.a, p.b + q.b, p.c + q.c}; }
  friend Germ operator-(const Germ& p, const Germ& q) { return {p.a - q.a, p.b - q.b, p.c - q.c}; }
  friend Germ operator*(const Germ& p, const Germ& q) {
    SCANKNIT_CHECK(p.b * q.c == 0 && p.c * q.b == 0 && p.c * q.c == 0);
    return {p.a * q.a, p.a * q.b + p.b * q.a, p.a * q.c + p.b * q.b + p.c * q.a};
  }
  [[nodiscard]] int sign() const {
    const Wide leading = a != 0 ? a : b != 0 ? b : c;
    return leading > 0 ? 1 : leading < 0 ? -1 : 0;
  }
};

/// numerator / denominator, the denominator positive.
struct Place {
  Germ numerator;
  Wide denominator = 1;

  [[nodiscard]] Germ times_denominator(const Germ& g) const { return g * Germ{denominator, 0, 0}; }
  friend int compare(const Place& p, const Place& q) {
    return (q.times_denominator(p.numerator) - p.times_denominator(q.numerator)).sign();
  }
};

class UnionFind {
 public:
  explicit UnionFind(std::size_t size) : parent_(size) { std::iota(parent_.begin(), parent_.end(), std::size_t{0}); }
  std::size_t root(std::size_t i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }
  void join(std::size_t i, std::size_t j) { parent_[root(i)] = root(j); }

 private:
  std::vector<std::size_t> parent_;
};

/// Four columns along x, c = y + 2z; AC - BD = column 0 * column 3 - column 1 * column 2 as a quadratic in x.
class Columns {
 public:
  explicit Columns(const std::array<std::int64_t, kCorners>& values) {
    for (std::size_t c = 0; c < 4; ++c) {
      start_[c] = {values[2 * c], 1, 0};
      end_[c] = {values[2 * c + 1], 1, 0};
    }
    constant_ = start_[0] * start_[3] - start_[1] * start_[2];
    linear_ = start_[0] * slope(3) + slope(0) * start_[3] - start_[1] * slope(2) - slope(1) * start_[2];
    quadratic_ = slope(0) * slope(3) - slope(1) * slope(2);
  }

  /// The places 0, 1 and those where a column changes its sign, each once, sorted.
  [[nodiscard]] std::vector<Place> crossings() const {
    std::vector<Place> places{{{0, 0, 0}, 1}, {{1, 0, 0}, 1}};
    for (std::size_t c = 0; c < 4; ++c) {
      if (is_crossed(c)) places.push_back(crossing(c));
    }
    std::sort(places.begin(), places.end(), [](const Place& p, const Place& q) { return compare(p, q) < 0; });
    const auto is_same = [](const Place& p, const Place& q) { return compare(p, q) == 0; };
    places.erase(std::unique(places.begin(), places.end(), is_same), places.end());
    return places;
  }
  /// Between `place` and the next crossing.
  [[nodiscard]] bool is_high_after(const Place& place, std::size_t c) const {
    return (is_crossed(c) && compare(crossing(c), place) <= 0 ? end_[c] : start_[c]).sign() > 0;
  }
  /// The signs that AC - BD takes, one after the other, in the open interval.
  [[nodiscard]] std::vector<int> determinant_signs(const Place& from, const Place& to) const {
    const int first = first_nonzero({determinant(from), derivative(from), quadratic_.sign()});
    const int last = first_nonzero({determinant(to), -derivative(to), quadratic_.sign()});
    if (first != last) return {first, last};
    const Germ discriminant = linear_ * linear_ - Germ{4, 0, 0} * quadratic_ * constant_;
    const bool has_vertex = derivative(from) * derivative(to) < 0;
    if (has_vertex && quadratic_.sign() == first && discriminant.sign() > 0) return {first, -first, first};
    return {first};
  }

 private:
  [[nodiscard]] Germ slope(std::size_t c) const { return end_[c] - start_[c]; }
  [[nodiscard]] bool is_crossed(std::size_t c) const { return start_[c].sign() != end_[c].sign(); }
  [[nodiscard]] Place crossing(std::size_t c) const {
    const Wide slope_of_column = slope(c).a;  // the infinitesimal cancels
    if (slope_of_column < 0) return {start_[c], -slope_of_column};
    return {Germ{} - start_[c], slope_of_column};
  }
  [[nodiscard]] int determinant(const Place& x) const {
    const Germ& n = x.numerator;
    const Germ linear_part = x.times_denominator(linear_ * n);
    return (x.times_denominator(x.times_denominator(constant_)) + linear_part + quadratic_ * (n * n)).sign();
  }
  [[nodiscard]] int derivative(const Place& x) const {
    return (x.times_denominator(linear_) + Germ{2, 0, 0} * quadratic_ * x.numerator).sign();
  }
  static int first_nonzero(const std::array<int, 3>& signs) {
    for (const int sign : signs) {
      if (sign != 0) return sign;
    }
    return 0;
  }

  std::array<Germ, 4> start_{};
  std::array<Germ, 4> end_{};
  Germ constant_, linear_, quadratic_;
};

/// The slices between two events: all alike.
struct Slab {
  std::array<bool, 4> is_high{};
  int determinant_sign = 0;

  [[nodiscard]] bool is_alternating() const {
    return is_high[0] == is_high[3] && is_high[1] == is_high[2] && is_high[0] != is_high[1];
  }
  /// Of an alternating slab: AC > BD joins A and C, be they High or Low; else B and D are joined.
  [[nodiscard]] std::array<std::size_t, 2> joined_diagonal() const {
    return determinant_sign > 0 ? std::array<std::size_t, 2>{0, 3} : std::array<std::size_t, 2>{1, 2};
  }
};

std::vector<Slab> slabs_of(const Columns& columns) {
  std::vector<Slab> slabs;
  const std::vector<Place> places = columns.crossings();
  for (std::size_t i = 0; i + 1 < places.size(); ++i) {
    Slab slab;
    for (std::size_t c = 0; c < 4; ++c) slab.is_high[c] = columns.is_high_after(places[i], c);
    for (const int sign : columns.determinant_signs(places[i], places[i + 1])) {
      slab.determinant_sign = sign;
      slabs.push_back(slab);
    }
  }
  return slabs;
}

/// The regions of {F >= 0} and {F < 0}: components of the corners of all slabs. Every component of a bilinear slice
/// holds a corner of it, and a corner of the same sign in two slabs keeps it in between.
class Regions {
 public:
  explicit Regions(const std::vector<Slab>& slabs) : slabs_(slabs), nodes_(4 * slabs.size()) {
    for (std::size_t s = 0; s < slabs.size(); ++s) {
      const Slab& slab = slabs[s];
      for (std::size_t a = 0; a < 4; ++a) {
        if (s > 0 && slabs[s - 1].is_high[a] == slab.is_high[a]) nodes_.join(4 * s + a, 4 * (s - 1) + a);
        for (const std::size_t b : {a ^ 1, a ^ 2}) {
          if (slab.is_high[a] == slab.is_high[b]) nodes_.join(4 * s + a, 4 * s + b);
        }
      }
      if (slab.is_alternating()) nodes_.join(4 * s + slab.joined_diagonal()[0], 4 * s + slab.joined_diagonal()[1]);
    }
  }
  [[nodiscard]] int count(bool high) {
    int regions = 0;
    for (std::size_t i = 0; i < 4 * slabs_.size(); ++i)
      regions += nodes_.root(i) == i && slabs_[i / 4].is_high[i % 4] == high ? 1 : 0;
    return regions;
  }
  /// Of a corner of the cell.
  [[nodiscard]] std::size_t at(int corner) {
    const auto c = static_cast<std::size_t>(corner / 2);
    return nodes_.root(corner % 2 == 0 ? c : 4 * (slabs_.size() - 1) + c);
  }

 private:
  const std::vector<Slab>& slabs_;
  UnionFind nodes_;
};

char resolve_face(const std::array<std::int64_t, kCorners>& values, std::size_t face) {
  std::array<Germ, 4> v;
  for (std::size_t i = 0; i < 4; ++i) v[i] = {values[static_cast<std::size_t>(kFaceCorners[face][i])], 1, 0};
  const bool is_first_high = v[0].sign() > 0;
  const auto is_like_first = [&](std::size_t i) { return (v[i].sign() > 0) == is_first_high; };
  if (is_like_first(1) || !is_like_first(2) || is_like_first(3)) return '.';
  return ((v[0] * v[2] - v[1] * v[3]).sign() > 0) == is_first_high ? 'H' : 'L';
}

/// The cell's boundary is a sphere: closed curves part it into one region more than there are curves.
int count_contours(const std::array<std::int64_t, kCorners>& values, const std::array<char, kFaces>& faces) {
  const auto is_high = [&](int corner) { return values[static_cast<std::size_t>(corner)] >= 0; };
  UnionFind corners(kCorners);
  const auto join = [&](int a, int b) { corners.join(static_cast<std::size_t>(a), static_cast<std::size_t>(b)); };
  for (int edge = 0; edge < kEdges; ++edge) {
    if (is_high(edge_low_corner(edge)) == is_high(edge_high_corner(edge)))
      join(edge_low_corner(edge), edge_high_corner(edge));
  }
  for (std::size_t face = 0; face < kFaces; ++face) {
    if (faces[face] == '.') continue;
    const std::size_t first = is_high(kFaceCorners[face][0]) == (faces[face] == 'H') ? 0 : 1;
    join(kFaceCorners[face][first], kFaceCorners[face][first + 2]);
  }
  int regions = 0;
  for (std::size_t i = 0; i < kCorners; ++i) regions += corners.root(i) == i ? 1 : 0;
  return regions - 1;
}

}  // namespace

CellTruth trilinear_truth(const std::array<std::int64_t, kCorners>& values) {
  for (const std::int64_t value : values) SCANKNIT_CHECK(value <= kLargestTruthValue && value >= -kLargestTruthValue);
  const std::vector<Slab> slabs = slabs_of(Columns(values));
  Regions regions(slabs);
  CellTruth truth;
  truth.high_regions = regions.count(true);
  truth.low_regions = regions.count(false);
  // Each component cuts the cell, a ball, into two. Each has genus 0: a disc, or an annulus where there is a tunnel.
  truth.components = truth.high_regions + truth.low_regions - 1;
  for (std::size_t face = 0; face < kFaces; ++face) truth.faces[face] = resolve_face(values, face);
  truth.contours = count_contours(values, truth.faces);
  truth.euler = 2 * truth.components - truth.contours;

  // Regions and the components between them are the nodes and edges of a tree: two regions name their component.
  std::vector<std::pair<std::size_t, std::size_t>> between;
  for (int edge = 0; edge < kEdges; ++edge) {
    const int low = edge_low_corner(edge);
    const int high = edge_high_corner(edge);
    int& component = truth.edge_component[static_cast<std::size_t>(edge)];
    component = -1;
    if ((values[static_cast<std::size_t>(low)] >= 0) == (values[static_cast<std::size_t>(high)] >= 0)) continue;
    const std::pair<std::size_t, std::size_t> sides = std::minmax({regions.at(low), regions.at(high)});
    const auto known = std::find(between.begin(), between.end(), sides);
    component = static_cast<int>(known - between.begin());
    if (known == between.end()) between.push_back(sides);
  }
  SCANKNIT_CHECK(static_cast<int>(between.size()) == truth.components);
  return truth;
}

namespace {

/// The cells of a volume and what glues them.
class VolumeCells {
 public:
  VolumeCells(std::span<const std::int64_t> values, const std::array<int, 3>& dims) : values_(values), dims_(dims) {}

  [[nodiscard]] std::size_t size() const { return values_.size(); }
  /// Is the cell, named by its first sample, inside the volume and observed?
  [[nodiscard]] bool is_whole(const std::array<int, 3>& cell) const {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (cell[axis] < 0 || cell[axis] + 1 >= dims_[axis]) return false;
    }
    const auto corners = values_of(cell);
    return std::find(corners.begin(), corners.end(), kUnobserved) == corners.end();
  }
  [[nodiscard]] std::array<std::int64_t, kCorners> values_of(const std::array<int, 3>& cell) const {
    std::array<std::int64_t, kCorners> corners{};
    for (int i = 0; i < kCorners; ++i) {
      const std::array<int, 3> at{cell[0] + (i & 1), cell[1] + ((i >> 1) & 1), cell[2] + (i >> 2)};
      corners[static_cast<std::size_t>(i)] = values_[index(at)];
    }
    return corners;
  }
  [[nodiscard]] std::size_t index(const std::array<int, 3>& at) const {
    const auto size = [](int n) { return static_cast<std::size_t>(n); };
    return (size(at[0]) * size(dims_[1]) + size(at[1])) * size(dims_[2]) + size(at[2]);
  }
  template <typename Visit>
  void for_each_whole(const Visit& visit) const {
    for (int x = 0; x + 1 < dims_[0]; ++x) {
      for (int y = 0; y + 1 < dims_[1]; ++y) {
        for (int z = 0; z + 1 < dims_[2]; ++z) {
          if (is_whole({x, y, z})) visit(std::array<int, 3>{x, y, z});
        }
      }
    }
  }

 private:
  std::span<const std::int64_t> values_;
  std::array<int, 3> dims_;
};

/// The surface as a set of open pieces: its patches inside the cells, its segments inside their faces, its vertices
/// on their edges. Euler characteristics add up; a segment without its ends counts -1.
class Pieces {
 public:
  explicit Pieces(const VolumeCells& cells)
      : cells_(cells), vertices_(kEdges * cells.size()), components_(kEdges * cells.size()) {
    cells.for_each_whole([&](const std::array<int, 3>& cell) { add(cell); });
  }
  [[nodiscard]] VolumeTruth count() {
    VolumeTruth truth;
    for (const std::size_t node : crossed_) {
      truth.vertices += vertices_.root(node) == node ? 1 : 0;
      truth.components += components_.root(node) == node ? 1 : 0;
    }
    truth.euler = patches_euler_ - segments_ + truth.vertices;
    return truth;
  }

 private:
  void add(const std::array<int, 3>& cell) {
    const std::size_t first = kEdges * cells_.index(cell);
    const CellTruth truth = trilinear_truth(cells_.values_of(cell));
    patches_euler_ += truth.euler;
    std::array<std::size_t, kEdges> node_of_component{};
    node_of_component.fill(kNone);
    for (std::size_t edge = 0; edge < kEdges; ++edge) {
      if (truth.edge_component[edge] < 0) continue;
      crossed_.push_back(first + edge);
      std::size_t& node = node_of_component[static_cast<std::size_t>(truth.edge_component[edge])];
      if (node == kNone) node = first + edge;
      components_.join(first + edge, node);
    }
    for (int axis = 0; axis < 3; ++axis) {
      const bool is_shared = glue(cell, axis, truth);
      segments_ += crossed_edges(truth, 2 * axis + 1) / 2 + (is_shared ? 0 : crossed_edges(truth, 2 * axis) / 2);
    }
  }
  /// Glues the cell to the one before it along an axis; false: there is none.
  bool glue(const std::array<int, 3>& cell, int axis, const CellTruth& truth) {
    std::array<int, 3> before = cell;
    before[static_cast<std::size_t>(axis)] -= 1;
    if (!cells_.is_whole(before)) return false;
    for (int edge = 0; edge < kEdges; ++edge) {
      if (truth.edge_component[static_cast<std::size_t>(edge)] < 0 || !is_in_face(edge, 2 * axis)) continue;
      const int opposite = edge_between(edge_low_corner(edge) | (1 << axis), edge_high_corner(edge) | (1 << axis));
      const std::size_t here = kEdges * cells_.index(cell) + static_cast<std::size_t>(edge);
      const std::size_t there = kEdges * cells_.index(before) + static_cast<std::size_t>(opposite);
      vertices_.join(here, there);
      components_.join(here, there);
    }
    return true;
  }
  static bool is_in_face(int edge, int face) { return ((kEdgeFaces[static_cast<std::size_t>(edge)] >> face) & 1) != 0; }
  static int crossed_edges(const CellTruth& truth, int face) {
    int count = 0;
    for (int edge = 0; edge < kEdges; ++edge)
      count += truth.edge_component[static_cast<std::size_t>(edge)] >= 0 && is_in_face(edge, face) ? 1 : 0;
    return count;
  }

  static constexpr std::size_t kNone = ~std::size_t{0};
  const VolumeCells& cells_;
  UnionFind vertices_;
  UnionFind components_;
  std::vector<std::size_t> crossed_;
  int patches_euler_ = 0;
  int segments_ = 0;
};

}  // namespace

VolumeTruth trilinear_truth(std::span<const std::int64_t> values, const std::array<int, 3>& dims) {
  SCANKNIT_CHECK(values.size() == static_cast<std::size_t>(dims[0]) * static_cast<std::size_t>(dims[1]) *
                                      static_cast<std::size_t>(dims[2]));
  const VolumeCells cells(values, dims);
  return Pieces(cells).count();
}

}  // namespace scanknit::test
