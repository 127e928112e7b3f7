#include "tvl/lidar/line_rows.h"

#include <algorithm>
#include <limits>
#include <utility>

namespace tvl {
namespace {

int UsualNumberOfBeams(int lines) {
  for (const int beams : {8, 16, 32, 40, 64, 80, 128}) {
    if (lines <= beams) return beams;
  }
  return lines;
}

// +1 where the elevation rises with the line, -1 where it falls, 0 for neither.
int Trend(const std::vector<LineElevation>& lines) {
  int rising = 0, falling = 0;
  double previous_rad = 0.0;
  bool is_first = true;
  for (const LineElevation& line : lines) {
    if (line.points == 0) continue;
    if (!is_first) ++(line.median_rad > previous_rad ? rising : falling);
    previous_rad = line.median_rad;
    is_first = false;
  }
  const int steps = rising + falling;
  return rising * 20 >= steps * 19 ? 1 : (falling * 20 >= steps * 19 ? -1 : 0);
}

std::vector<LineElevation> WithUnseenLines(std::vector<LineElevation> lines, int usual) {
  lines.resize(static_cast<size_t>(usual));
  std::vector<size_t> seen;
  for (size_t i = 0; i < lines.size(); ++i) {
    if (lines[i].points > 0) seen.push_back(i);
  }
  if (seen.size() < 2) return lines;
  for (size_t i = 0; i < lines.size(); ++i) {
    if (lines[i].points > 0) continue;
    const auto after = std::lower_bound(seen.begin(), seen.end(), i);
    const size_t b = after == seen.begin() ? seen[1] : after == seen.end() ? seen.back() : *after;
    const size_t a = after == seen.begin() ? seen[0]
                     : after == seen.end() ? seen[seen.size() - 2]
                                           : *(after - 1);
    const double step = (lines[b].median_rad - lines[a].median_rad) / static_cast<double>(b - a);
    lines[i].median_rad =
        lines[a].median_rad + step * (static_cast<double>(i) - static_cast<double>(a));
    lines[i].points = 1;
  }
  return lines;
}

// Lines are beams where their points scatter by less than lines lie apart.
bool AreBeams(const std::vector<LineElevation>& lines) {
  std::vector<double> scatters_rad;
  double lowest = std::numeric_limits<double>::infinity(), highest = -lowest;
  for (const LineElevation& line : lines) {
    if (line.points < 20) continue;  // fewer have no median to speak of
    scatters_rad.push_back(line.scatter_rad);
    lowest = std::min(lowest, line.median_rad), highest = std::max(highest, line.median_rad);
  }
  if (scatters_rad.size() < 4) return false;
  const auto middle = scatters_rad.begin() + static_cast<std::ptrdiff_t>(scatters_rad.size() / 2);
  std::nth_element(scatters_rad.begin(), middle, scatters_rad.end());
  return *middle < 0.5 * (highest - lowest) / static_cast<double>(scatters_rad.size() - 1);
}

// More lines than any lidar has beams.
constexpr int kMostLines = 512;

}  // namespace

LineRows SortLines(std::vector<LineElevation> lines) {
  if (Trend(lines) != 0) {
    const int usual = UsualNumberOfBeams(static_cast<int>(lines.size()));
    lines = WithUnseenLines(std::move(lines), usual);
  }
  std::vector<size_t> order;
  for (size_t i = 0; i < lines.size(); ++i) {
    if (lines[i].points > 0) order.push_back(i);
  }
  std::stable_sort(order.begin(), order.end(),
                   [&](size_t a, size_t b) { return lines[a].median_rad > lines[b].median_rad; });
  LineRows rows;
  rows.row_of_line.assign(lines.size(), -1);
  for (const size_t line : order) {
    rows.row_of_line[line] = static_cast<int>(rows.beams.size());
    rows.beams.push_back(lines[line]);
  }
  return rows;
}

std::optional<LineRows> RowsOfLines(const std::vector<const RawScan*>& scans,
                                    const std::vector<std::vector<int>>& line_of, int lines) {
  if (lines < 4 || lines > kMostLines) return std::nullopt;
  const std::vector<LineElevation> measured = MeasureLines(scans, line_of, lines);
  if (!AreBeams(measured)) return std::nullopt;
  return SortLines(measured);
}

}  // namespace tvl
