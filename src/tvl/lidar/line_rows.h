// Rows of the range image for the lines of scans: rings by their numbers, or rows or columns of an
// organised cloud.
#pragma once

#include <optional>
#include <vector>

#include "tvl/lidar/beam_elevations.h"
#include "tvl/sensor/raw_scan.h"

namespace tvl {

struct LineRows {
  std::vector<int> row_of_line;      // 0 topmost; -1: no row, points are not expected there
  std::vector<LineElevation> beams;  // of the rows
};

// Topmost first, by the measured elevations. Lines without points: between others they are
// interpolated. Where elevations rise or fall with the number of the line, those beyond the ones
// seen are extrapolated up to the next usual number of beams, since a beam that looks at the sky
// may have its first return later; else they have no row.
LineRows SortLines(std::vector<LineElevation> lines);

// `line_of` has an entry a point of each scan, -1 for none. Empty where the lines are no beams:
// fewer than 4, more than 512, or points of one line that scatter by more than half of what lines
// lie apart.
std::optional<LineRows> RowsOfLines(const std::vector<const RawScan*>& scans,
                                    const std::vector<std::vector<int>>& line_of, int lines);

}  // namespace tvl
