// SPDX-License-Identifier: Apache-2.0
#include "mpi_team.h"

#include <fmt/format.h>
#include <mpi.h>
#include <sched.h>

#include <algorithm>
#include <numeric>
#include <thread>
#include <vector>

#include "console.h"
#include "picture_part.h"
#include "session.h"
#include "usage.h"

namespace ovoid::cli {
namespace {

using Run = DeepImage::Run;

// How many processors this process may use, of those that others of the team on this machine use,
// too.
int threads_of_this_process() {
  cpu_set_t set;
  CPU_ZERO(&set);
  const int own = sched_getaffinity(0, sizeof(set), &set) == 0 ? CPU_COUNT(&set) : 1;
  const int all = std::max(static_cast<int>(std::thread::hardware_concurrency()), 1);
  MPI_Comm machine = MPI_COMM_NULL;
  MPI_Comm_split_type(MPI_COMM_WORLD, MPI_COMM_TYPE_SHARED, 0, MPI_INFO_NULL, &machine);
  int beside = 1;
  MPI_Comm_size(machine, &beside);
  MPI_Comm_free(&machine);
  // Who is bound to some has these to himself.
  return std::max(own < all ? own : all / beside, 1);
}

// Rows of the picture that each process puts together: [first, first of the next).
int first_row(int height, int process, int count) {
  return static_cast<int>(std::int64_t{height} * process / count);
}

// A type of MPI for as long as it is used.
class MpiType {
 public:
  MpiType(int count, MPI_Datatype of) {
    MPI_Type_contiguous(count, of, &type_);
    MPI_Type_commit(&type_);
  }
  ~MpiType() { MPI_Type_free(&type_); }
  MpiType(const MpiType&) = delete;
  MpiType& operator=(const MpiType&) = delete;
  MPI_Datatype get() const { return type_; }

 private:
  MPI_Datatype type_ = MPI_DATATYPE_NULL;
};

// How much goes to, or comes from, each process.
struct Shares {
  std::vector<int> counts, offsets;
  explicit Shares(int processes)
      : counts(static_cast<std::size_t>(processes)), offsets(static_cast<std::size_t>(processes)) {}
  // What the counts add up to.
  int set_offsets() {
    std::exclusive_scan(counts.begin(), counts.end(), offsets.begin(), 0);
    return offsets.back() + counts.back();
  }
};

// What everybody has seen of the rows that this process puts together.
std::vector<DeepImage> exchanged(const DeepImage& seen, int process, int processes,
                                 std::int64_t* bytes) {
  const auto width = static_cast<std::size_t>(seen.width);
  const auto pixel_of_row = [&](int row) { return static_cast<std::size_t>(row) * width; };
  const int own_first = first_row(seen.height, process, processes);
  const int own_rows = first_row(seen.height, process + 1, processes) - own_first;

  // Of every pixel how many runs, then the runs.
  std::vector<std::uint32_t> counts(pixel_of_row(seen.height));
  for (std::size_t i = 0; i < counts.size(); ++i) counts[i] = seen.first[i + 1] - seen.first[i];
  Shares pixels_out(processes), pixels_in(processes), runs_out(processes), runs_in(processes);
  for (int to = 0; to < processes; ++to) {
    const auto at = static_cast<std::size_t>(to);
    const std::size_t begin = pixel_of_row(first_row(seen.height, to, processes));
    const std::size_t end = pixel_of_row(first_row(seen.height, to + 1, processes));
    pixels_out.counts[at] = static_cast<int>(end - begin);
    runs_out.counts[at] = static_cast<int>(seen.first[end] - seen.first[begin]);
    pixels_in.counts[at] = static_cast<int>(pixel_of_row(own_rows));
    if (to != process)
      *bytes +=
          static_cast<std::int64_t>((end - begin) * sizeof(std::uint32_t)) +
          static_cast<std::int64_t>(runs_out.counts[at]) * static_cast<std::int64_t>(sizeof(Run));
  }
  pixels_out.set_offsets();
  std::vector<std::uint32_t> counts_in(static_cast<std::size_t>(pixels_in.set_offsets()));
  MPI_Alltoallv(counts.data(), pixels_out.counts.data(), pixels_out.offsets.data(), MPI_UINT32_T,
                counts_in.data(), pixels_in.counts.data(), pixels_in.offsets.data(), MPI_UINT32_T,
                MPI_COMM_WORLD);
  MPI_Alltoall(runs_out.counts.data(), 1, MPI_INT, runs_in.counts.data(), 1, MPI_INT,
               MPI_COMM_WORLD);
  runs_out.set_offsets();
  std::vector<Run> runs(static_cast<std::size_t>(runs_in.set_offsets()));
  const MpiType run(sizeof(Run), MPI_BYTE);
  MPI_Alltoallv(seen.runs.data(), runs_out.counts.data(), runs_out.offsets.data(), run.get(),
                runs.data(), runs_in.counts.data(), runs_in.offsets.data(), run.get(),
                MPI_COMM_WORLD);

  std::vector<DeepImage> from_all;
  for (int from = 0; own_rows > 0 && from < processes; ++from) {
    const auto at = static_cast<std::size_t>(from);
    DeepImage& image = from_all.emplace_back();
    image.width = seen.width;
    image.height = own_rows;
    image.mode = seen.mode;
    const auto own = std::span(counts_in).subspan(static_cast<std::size_t>(pixels_in.offsets[at]),
                                                  static_cast<std::size_t>(pixels_in.counts[at]));
    image.first.resize(own.size() + 1);
    std::inclusive_scan(own.begin(), own.end(), image.first.begin() + 1);
    const auto begin = runs.begin() + runs_in.offsets[at];
    image.runs.assign(begin, begin + runs_in.counts[at]);
  }
  return from_all;
}

// Rows of numbers of all processes, at the first one.
void gather_rows(const std::vector<float>& own, int per_pixel, int width, int height, int process,
                 int processes, std::vector<float>& all) {
  const MpiType row(width * per_pixel, MPI_FLOAT);
  Shares rows(processes);
  for (int from = 0; from < processes; ++from)
    rows.counts[static_cast<std::size_t>(from)] =
        first_row(height, from + 1, processes) - first_row(height, from, processes);
  rows.set_offsets();
  if (process == 0)
    all.resize(static_cast<std::size_t>(width) * static_cast<std::size_t>(per_pixel) *
               static_cast<std::size_t>(height));
  MPI_Gatherv(own.data(), rows.counts[static_cast<std::size_t>(process)], row.get(), all.data(),
              rows.counts.data(), rows.offsets.data(), row.get(), 0, MPI_COMM_WORLD);
}

}  // namespace

MpiTeam::MpiTeam(std::chrono::duration<double> patience) : patience_(patience) {
  MPI_Comm_rank(MPI_COMM_WORLD, &number_);
  MPI_Comm_size(MPI_COMM_WORLD, &count_);
  threads_ = threads_of_this_process();
}

// Nobody can be told any more but by ending the job.
void MpiTeam::give_up() const {
  complain(fmt::format("process {} of {} has waited {:g} s for the others, and gives up "
                       "(OVOID_MPI_WAIT sets how long)",
                       number_, count_, patience_.count()),
           kExitFailed);
  MPI_Abort(MPI_COMM_WORLD, kExitFailed);
  std::abort();
}

void MpiTeam::meet(const std::string& problem, int exit_code) {
  std::vector<int> codes(static_cast<std::size_t>(count_));
  MPI_Request request = MPI_REQUEST_NULL;
  MPI_Iallgather(&exit_code, 1, MPI_INT, codes.data(), 1, MPI_INT, MPI_COMM_WORLD, &request);
  // Of several that wait the first gives up for all.
  using Clock = std::chrono::steady_clock;
  const std::chrono::duration<double> longest = patience_ + std::chrono::seconds(number_);
  const Clock::time_point start = Clock::now();
  auto pause = std::chrono::microseconds(20);
  for (int has_come = 0;;) {
    MPI_Test(&request, &has_come, MPI_STATUS_IGNORE);
    if (has_come != 0) break;
    if (Clock::now() - start > longest) give_up();
    std::this_thread::sleep_for(pause);
    pause = std::min(pause * 2, std::chrono::microseconds(2000));
  }
  const auto failed = std::find_if(codes.begin(), codes.end(), [](int code) { return code != 0; });
  if (failed == codes.end()) return;
  const int who = static_cast<int>(failed - codes.begin());
  const bool are_all_alike =
      std::all_of(codes.begin(), codes.end(), [&](int code) { return code == *failed; });
  const std::string text = text_of(who, problem);
  throw TeamError(are_all_alike ? text : fmt::format("process {} of {}: {}", who, count_, text),
                  *failed);
}

// The text of one process, in all.
std::string MpiTeam::text_of(int process, const std::string& own) const {
  auto size = static_cast<int>(own.size());
  MPI_Bcast(&size, 1, MPI_INT, process, MPI_COMM_WORLD);
  std::string text = own;
  text.resize(static_cast<std::size_t>(size));
  MPI_Bcast(text.data(), size, MPI_CHAR, process, MPI_COMM_WORLD);
  return text;
}

void MpiTeam::agree(const std::string& lines) {
  meet({}, 0);
  const std::string line = differing_line(lines, text_of(0, lines));
  if (line.empty()) return meet({}, 0);
  meet(fmt::format("draws another picture than process 0, '{}' differs: the same command and the "
                   "same files are needed everywhere",
                   line),
       kExitFailed);
}

Team::Spread MpiTeam::spread(double value) {
  const double both[2] = {-value, value};
  double greatest[2];
  MPI_Allreduce(both, greatest, 2, MPI_DOUBLE, MPI_MAX, MPI_COMM_WORLD);
  return {-greatest[0], greatest[1]};
}

std::optional<Team::Picture> MpiTeam::put_together(const DeepImage& seen, const Look& look) {
  const Stopwatch exchanging;
  Picture picture;
  const std::vector<DeepImage> from_all = exchanged(seen, number_, count_, &picture.bytes);
  picture.exchange_ms = exchanging.ms();
  const Stopwatch compositing;
  Image own;
  std::string problem;
  try {
    if (!from_all.empty()) own = composited(merged(from_all), look);
  } catch (const std::exception& error) {
    problem = error.what();
  }
  meet(problem, problem.empty() ? 0 : kExitFailed);
  picture.composite_ms = compositing.ms();
  const Stopwatch gathering;
  picture.image.width = seen.width;
  picture.image.height = seen.height;
  const auto gather = [&](const std::vector<float>& numbers, int per_pixel,
                          std::vector<float>& all) {
    if (number_ != 0) picture.bytes += static_cast<std::int64_t>(numbers.size() * sizeof(float));
    gather_rows(numbers, per_pixel, seen.width, seen.height, number_, count_, all);
  };
  gather(own.rgba, 4, picture.image.rgba);
  gather(own.depth, 1, picture.image.depth);
  gather(own.front_depth, 1, picture.image.front_depth);
  picture.exchange_ms += gathering.ms();
  std::int64_t bytes = 0;
  MPI_Reduce(&picture.bytes, &bytes, 1, MPI_INT64_T, MPI_SUM, 0, MPI_COMM_WORLD);
  picture.bytes = bytes;
  picture.exchange_ms = spread(picture.exchange_ms).greatest;
  picture.composite_ms = spread(picture.composite_ms).greatest;
  if (number_ != 0) return std::nullopt;
  return picture;
}

}  // namespace ovoid::cli
