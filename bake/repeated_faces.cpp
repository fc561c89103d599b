#include "bake/repeated_faces.h"

#include <algorithm>
#include <array>
#include <numeric>
#include <utility>

namespace ohb::bake {
namespace {

std::array<float, 3> key_of(Vec3f p) {
  return {p.x, p.y, p.z};
}
std::array<float, 2> key_of(Vec2f p) {
  return {p.x, p.y};
}

/// A number for each value; equal values have the same.
template <class Value>
std::vector<uint32_t> numbers_of(const std::vector<Value>& values) {
  std::vector<uint32_t> order(values.size());
  std::iota(order.begin(), order.end(), 0u);
  std::sort(order.begin(), order.end(),
            [&](uint32_t a, uint32_t b) { return key_of(values[a]) < key_of(values[b]); });
  std::vector<uint32_t> numbers(values.size());
  uint32_t number = 0;
  for (size_t i = 0; i < order.size(); ++i) {
    if (i > 0 && key_of(values[order[i - 1]]) < key_of(values[order[i]])) ++number;
    numbers[order[i]] = number;
  }
  return numbers;
}

}  // namespace

std::vector<bool> repeated_faces(const Scan& scan) {
  const std::vector<uint32_t> position = numbers_of(scan.positions), uv = numbers_of(scan.uvs);
  using Place = std::pair<uint32_t, uint32_t>;  // position, UV
  std::vector<Place> places(scan.corners.size());
  for (size_t f = 0; f < scan.face_count(); ++f) {
    const bool is_cut = !scan.materials[scan.face_material[f]].alpha.empty();
    for (uint32_t c = scan.face_begin[f]; c < scan.face_begin[f + 1]; ++c) {
      const Corner& corner = scan.corners[c];
      const bool has_uv = is_cut && corner.uv != Corner::kNoUv;
      places[c] = {position[corner.position], has_uv ? uv[corner.uv] : 0};
    }
    std::sort(places.begin() + scan.face_begin[f], places.begin() + scan.face_begin[f + 1]);
  }
  const auto compare = [&](uint32_t a, uint32_t b) {
    if (scan.face_material[a] != scan.face_material[b])
      return scan.face_material[a] < scan.face_material[b] ? -1 : 1;
    const auto begin = [&](uint32_t f) { return places.begin() + scan.face_begin[f]; };
    const auto end = [&](uint32_t f) { return places.begin() + scan.face_begin[f + 1]; };
    if (std::lexicographical_compare(begin(a), end(a), begin(b), end(b))) return -1;
    return std::equal(begin(a), end(a), begin(b), end(b)) ? 0 : 1;
  };
  // By the first two positions, which nearly always tell faces apart, then by all.
  std::vector<std::pair<uint64_t, uint32_t>> order(scan.face_count());
  for (uint32_t f = 0; f < order.size(); ++f) {
    const Place* place = &places[scan.face_begin[f]];
    order[f] = {uint64_t{place[0].first} << 32 | place[1].first, f};
  }
  std::sort(order.begin(), order.end(), [&](const auto& a, const auto& b) {
    if (a.first != b.first) return a.first < b.first;
    const int sign = compare(a.second, b.second);
    return sign != 0 ? sign < 0 : a.second < b.second;
  });
  std::vector<bool> repeated(order.size(), false);
  for (size_t i = 1; i < order.size(); ++i)
    repeated[order[i].second] =
        order[i - 1].first == order[i].first && compare(order[i - 1].second, order[i].second) == 0;
  return repeated;
}

}  // namespace ohb::bake
