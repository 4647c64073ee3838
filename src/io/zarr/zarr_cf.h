// SPDX-License-Identifier: Apache-2.0
// The arrays of a Zarr hierarchy as variables on named dimensions, as xarray writes them.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "io/core/cf_file.h"
#include "io/zarr/zarr_array.h"
#include "io/zarr/zarr_store.h"

namespace ovoid::io {

// One variable for each of the nodes, in their order, whose type is told by zarr_array() alone.
// Dimensions are those of a group that are called alike and as long as each other.
class ZarrCfFile final : public CfFile {
 public:
  // `nodes`: arrays, which outlive this. `name`: of the hierarchy, for messages.
  ZarrCfFile(std::string name, std::shared_ptr<const ZarrStore> store,
             const std::vector<ZarrNode>& nodes);

  const CfDescription& description() const override { return description_; }
  const CfVariable& variable_of(const ZarrNode& node) const {
    return description_.variables[static_cast<std::size_t>(&node - nodes_.data())];
  }
  std::vector<double> numbers(const CfVariable& variable, std::int64_t most) const override;
  ChunkedArray array(const CfVariable& variable, bool may_stay) const override;
  CfFill fill() const override { return CfFill::kNone; }  // their fill values stand in them

 private:
  const ZarrNode& node_of(const CfVariable& variable) const {
    return nodes_[static_cast<std::size_t>(&variable - description_.variables.data())];
  }

  std::shared_ptr<const ZarrStore> store_;
  const std::vector<ZarrNode>& nodes_;
  CfDescription description_;
};

}  // namespace ovoid::io
