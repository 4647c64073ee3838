// SPDX-License-Identifier: Apache-2.0
// VTK's two-dimensional transfer functions as the library's tables.

#include <fmt/format.h>
#include <vtkDataArray.h>
#include <vtkImageData.h>
#include <vtkPointData.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

#include "ovoid/error.h"
#include "property_look.h"

namespace ovoid::mappers {
namespace {

using Rgba = TransferFunction2D::Rgba;

// Entries along both axes, and these.
struct Table {
  int columns = 0;
  int rows = 0;
  std::vector<Rgba> entries;  // [rows, columns]

  const Rgba& at(int column, int row) const {
    return entries[static_cast<std::size_t>(row) * static_cast<std::size_t>(columns) +
                   static_cast<std::size_t>(column)];
  }
};

Table table_of(vtkImageData* image) {
  vtkDataArray* const array = image->GetPointData()->GetScalars();
  const int* const dims = image->GetDimensions();
  if (array == nullptr || array->GetNumberOfComponents() != 4 || dims[2] != 1) {
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("TransferFunction2D: an image of {} x {} x {} with {} components: "
                            "expected one slice of red, green, blue and opacity",
                            dims[0], dims[1], dims[2],
                            array != nullptr ? array->GetNumberOfComponents() : 0));
  }
  Table table{dims[0], dims[1], {}};
  table.entries.resize(static_cast<std::size_t>(array->GetNumberOfTuples()));
  for (std::size_t i = 0; i < table.entries.size(); ++i) {
    for (int c = 0; c < 4; ++c) {
      const double value = array->GetComponent(static_cast<vtkIdType>(i), c);
      table.entries[i][static_cast<std::size_t>(c)] =
          static_cast<float>(value > 0 ? std::min(value, 1.0) : 0.0);  // NaN: 0
    }
  }
  return table;
}

// Bilinear, from first entry to first and from last to last.
Table resized(const Table& table, int columns, int rows) {
  Table out{columns, rows, {}};
  out.entries.reserve(static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows));
  const auto place = [](int i, int count, int old_count, int* first) {
    const double x = static_cast<double>(i) * (old_count - 1) / (count - 1);
    *first = std::min(static_cast<int>(x), std::max(old_count - 2, 0));
    return static_cast<float>(x - *first);
  };
  for (int row = 0; row < rows; ++row) {
    int y = 0;
    const float t = place(row, rows, table.rows, &y);
    const int next_y = std::min(y + 1, table.rows - 1);
    for (int column = 0; column < columns; ++column) {
      int x = 0;
      const float s = place(column, columns, table.columns, &x);
      const int next_x = std::min(x + 1, table.columns - 1);
      Rgba entry{};
      for (std::size_t c = 0; c < 4; ++c) {
        entry[c] = std::lerp(std::lerp(table.at(x, y)[c], table.at(next_x, y)[c], s),
                             std::lerp(table.at(x, next_y)[c], table.at(next_x, next_y)[c], s), t);
        entry[c] = std::clamp(entry[c], 0.0F, 1.0F);
      }
      out.entries.push_back(entry);
    }
  }
  return out;
}

// As large as the library's tables may be.
Table fitting(const Table& table) {
  const double all = static_cast<double>(table.columns) * table.rows;
  const double shrink = std::sqrt(std::max(1.0, all / TransferFunction2D::kMaxEntries));
  const auto count = [&](int old_count) {
    return std::clamp(static_cast<int>(old_count / shrink), 2,
                      TransferFunction2D::kMaxEntriesAlong);
  };
  Table fit{count(table.columns), count(table.rows), {}};
  // One axis that cannot shrink leaves too much to the other.
  const auto most = static_cast<int>(TransferFunction2D::kMaxEntries);
  fit.columns = std::min(fit.columns, most / fit.rows);
  fit.rows = std::min(fit.rows, most / fit.columns);
  if (fit.columns == table.columns && fit.rows == table.rows) return table;
  return resized(table, fit.columns, fit.rows);
}

}  // namespace

TransferFunction2D table_of_function(vtkImageData* function, double weight, const ValueRange& range,
                                     double steepest) {
  if (function == nullptr) {
    throw Error(ErrorCode::kInvalidArgument,
                "TransferFunctionMode is two-dimensional, and TransferFunction2D is not set");
  }
  Table table = fitting(table_of(function));
  for (Rgba& entry : table.entries) entry[3] *= static_cast<float>(weight);
  const double lo = range.lo;
  const double hi = range.lo < range.hi ? range.hi : lo + 1;
  return {{lo, hi, table.columns}, {0, steepest, table.rows}, std::move(table.entries)};
}

}  // namespace ovoid::mappers
