// SPDX-License-Identifier: Apache-2.0
#include "end_job.h"

#include <mpi.h>

#include <cstdlib>

#include "console.h"
#include "interrupt.h"
#include "usage.h"

namespace ovoid::cli {

void end_job(const std::string& message) {
  complain(message, kExitFailed);
  Interrupt::be_silent();
  MPI_Abort(MPI_COMM_WORLD, kExitFailed);
  std::abort();
}

}  // namespace ovoid::cli
