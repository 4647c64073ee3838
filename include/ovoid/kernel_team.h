// SPDX-License-Identifier: Apache-2.0
// Processes that have one kernel set together, each a share of it. docs/many-processes.md.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

#include "ovoid/dataset.h"
#include "ovoid/export.h"

namespace OVOID_API ovoid {

// How the processes of a team reach each other; the caller's matter, of which the library sees
// this much. ovoid-mpi has one of MPI.
class KernelTeam {
 public:
  virtual ~KernelTeam() = default;

  virtual int number() const noexcept = 0;  // of this process, from 0
  virtual int count() const noexcept = 0;

  // One for each process.
  using Letters = std::vector<std::vector<std::byte>>;
  // Letter k goes to process k; what comes from process k stands at k of the result. All call it,
  // at the same places in the same order. Throws, in all, if one of them has failed.
  virtual Letters exchange(Letters letters) = 0;

  // What fetch() of the others gives for a number, from now until the team ends; called by threads
  // of the team's own. All call it. Returns what the others ask for it by.
  using Answer = std::function<std::vector<std::byte>(std::int64_t number)>;
  virtual int answer(Answer answer) = 0;
  // What process `process` answers to `number`; `question` is what answer() has returned. Many
  // threads may ask at once. Throws Error if nothing comes back.
  virtual std::vector<std::byte> fetch(int process, int question, std::int64_t number) const = 0;
};

// Which array the whole would be drawn by where none is named: shares by themselves may have
// columns that do not vary. Stored in dataset.share, where Dataset::array() looks. All call it.
// Throws Error(kInvalidArgument) for a dataset that is no share, or if the shares of all are not
// one dataset's.
void agree_on_array(Dataset& share, KernelTeam& team);

}  // namespace ovoid
