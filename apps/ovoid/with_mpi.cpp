// SPDX-License-Identifier: Apache-2.0
// mpirun -n N ovoid render: hands over to a program of its own, so that drawing alone needs no MPI.

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <string>

#include "command.h"
#include "environment.h"
#include "other_program.h"
#include "ovoid/error.h"
#include "usage.h"

namespace ovoid::cli {
namespace {

int number_in(const char* name) { return std::atoi(value_of(name).c_str()); }

}  // namespace

// Open MPI, MPICH and its kin, Slurm's PMIx: each tells how many there are.
int processes_by_mpi() {
  if (value_of("OVOID_MPI") == "0") return 0;
  const int of_slurm = value_of("PMIX_RANK").empty() ? 0 : number_in("SLURM_NTASKS");
  return std::max({number_in("OMPI_COMM_WORLD_SIZE"), number_in("PMI_SIZE"), of_slurm, 0});
}

bool speaks_for_all() {
  for (const char* const name : {"OMPI_COMM_WORLD_RANK", "PMI_RANK", "PMIX_RANK"}) {
    if (!value_of(name).empty()) return number_in(name) == 0;
  }
  return true;
}

void run_with_mpi(const Words& words) {
  if (words.empty() || words.front() != "render")
    throw UsageError(
        "started by MPI as several processes, which is for ovoid render alone (OVOID_MPI=0 lets "
        "each of them work for itself)");
  const auto [program, is_there] = program_beside("ovoid-mpi");
  if (!is_there) {
    throw Error(
        ErrorCode::kUnsupported,
        fmt::format("render: was started by MPI, and this installation is without it, there "
                    "is no {}; without it: ovoid render --part K/N, then ovoid composite",
                    program));
  }
  setenv(kProcessesOfLauncher, std::to_string(processes_by_mpi()).c_str(), 1);
  become(program, {words.begin() + 1, words.end()}, "render");
}

}  // namespace ovoid::cli
