// SPDX-License-Identifier: Apache-2.0
#include "mpi_team.h"

#include <fmt/format.h>
#include <mpi.h>
#include <sched.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <numeric>
#include <span>
#include <thread>
#include <vector>

#include "console.h"
#include "end_job.h"
#include "picture_part.h"
#include "session.h"
#include "usage.h"

namespace ovoid::cli {
namespace {

using Run = DeepImage::Run;

constexpr double kDrawingPatience = 100;  // times as long as for what is read

// Processes of the team on this machine, the number of this one among them, and how many threads
// each takes.
struct Neighbors {
  int count, place, threads;
};

// Processors that a process may use are often those of others, too, and then shared with them.
Neighbors look_around() {
  constexpr std::size_t kMostProcessors = 8192;
  using Mask = std::array<std::uint8_t, kMostProcessors / 8>;
  Mask own{};
  if (sched_getaffinity(0, own.size(), reinterpret_cast<cpu_set_t*>(own.data())) != 0) own[0] = 1;
  MPI_Comm machine = MPI_COMM_NULL;
  MPI_Comm_split_type(MPI_COMM_WORLD, MPI_COMM_TYPE_SHARED, 0, MPI_INFO_NULL, &machine);
  Neighbors found{1, 0, 1};
  MPI_Comm_size(machine, &found.count);
  MPI_Comm_rank(machine, &found.place);
  std::vector<Mask> all(static_cast<std::size_t>(found.count));
  MPI_Allgather(own.data(), sizeof(Mask), MPI_BYTE, all.data(), sizeof(Mask), MPI_BYTE, machine);
  MPI_Comm_free(&machine);
  int processors = 0;
  for (const std::uint8_t bits : own) processors += std::popcount(bits);
  const auto sharing = std::count_if(all.begin(), all.end(), [&](const Mask& mask) {
    for (std::size_t i = 0; i < own.size(); ++i) {
      if ((mask[i] & own[i]) != 0) return true;
    }
    return false;
  });
  found.threads = std::max(processors / static_cast<int>(std::max<std::ptrdiff_t>(sharing, 1)), 1);
  return found;
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

// A run on its way: most processes see little of the picture, so pixels without any are not sent.
struct SentRun {
  std::uint32_t pixel;  // of the rows of the process that it goes to
  Run run;
};

// Runs of one process, by pixel, as a picture of so many rows.
DeepImage picture_of_rows(std::span<const SentRun> sent, const DeepImage& like, int rows) {
  DeepImage image;
  image.width = like.width;
  image.height = rows;
  image.mode = like.mode;
  image.first.assign(static_cast<std::size_t>(like.width) * static_cast<std::size_t>(rows) + 1, 0);
  image.runs.reserve(sent.size());
  for (const SentRun& one : sent) {
    ++image.first[one.pixel + 1];
    image.runs.push_back(one.run);
  }
  std::inclusive_scan(image.first.begin(), image.first.end(), image.first.begin());
  return image;
}

// What everybody has seen of the rows that this process puts together.
std::vector<DeepImage> exchanged(const DeepImage& seen, int process, int processes,
                                 std::int64_t* bytes) {
  const auto width = static_cast<std::size_t>(seen.width);
  Shares out(processes), in(processes);
  std::vector<SentRun> sent;
  sent.reserve(seen.runs.size());
  for (int to = 0; to < processes; ++to) {
    const std::size_t begin =
        static_cast<std::size_t>(first_row(seen.height, to, processes)) * width;
    const std::size_t end =
        static_cast<std::size_t>(first_row(seen.height, to + 1, processes)) * width;
    for (std::size_t pixel = begin; pixel < end; ++pixel) {
      for (std::uint32_t i = seen.first[pixel]; i < seen.first[pixel + 1]; ++i)
        sent.push_back({static_cast<std::uint32_t>(pixel - begin), seen.runs[i]});
    }
    int& count = out.counts[static_cast<std::size_t>(to)];
    count = static_cast<int>(seen.first[end] - seen.first[begin]);
    if (to != process)
      *bytes += static_cast<std::int64_t>(count) * static_cast<std::int64_t>(sizeof(SentRun));
  }
  MPI_Alltoall(out.counts.data(), 1, MPI_INT, in.counts.data(), 1, MPI_INT, MPI_COMM_WORLD);
  out.set_offsets();
  std::vector<SentRun> received(static_cast<std::size_t>(in.set_offsets()));
  const MpiType run(sizeof(SentRun), MPI_BYTE);
  MPI_Alltoallv(sent.data(), out.counts.data(), out.offsets.data(), run.get(), received.data(),
                in.counts.data(), in.offsets.data(), run.get(), MPI_COMM_WORLD);
  const int own_rows =
      first_row(seen.height, process + 1, processes) - first_row(seen.height, process, processes);
  std::vector<DeepImage> from_all;
  for (std::size_t from = 0; own_rows > 0 && from < in.counts.size(); ++from)
    from_all.push_back(
        picture_of_rows(std::span(received).subspan(static_cast<std::size_t>(in.offsets[from]),
                                                    static_cast<std::size_t>(in.counts[from])),
                        seen, own_rows));
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

MpiTeam::MpiTeam(Duration patience, bool has_threads) : patience_(patience) {
  MPI_Comm_rank(MPI_COMM_WORLD, &number_);
  MPI_Comm_size(MPI_COMM_WORLD, &count_);
  const Neighbors neighbors = look_around();
  beside_ = neighbors.count;
  place_ = neighbors.place;
  threads_ = neighbors.threads;
  if (has_threads && count_ > 1)
    kernels_ = std::make_shared<MpiKernelTeam>(
        number_, count_, [this] { meet_within(patience_, {}, 0); }, kDrawingPatience * patience_);
}

void MpiTeam::meet(const std::string& problem, int exit_code) {
  meet_within(kDrawingPatience * patience_, problem, exit_code);
}

void MpiTeam::meet_within(Duration longest, const std::string& problem, int exit_code) {
  std::vector<int> codes(static_cast<std::size_t>(count_));
  MPI_Request request = MPI_REQUEST_NULL;
  MPI_Iallgather(&exit_code, 1, MPI_INT, codes.data(), 1, MPI_INT, MPI_COMM_WORLD, &request);
  using Clock = std::chrono::steady_clock;
  // Of several that wait the first gives up for all.
  const Duration own_longest = longest + std::chrono::seconds(number_);
  const Clock::time_point start = Clock::now();
  auto pause = std::chrono::microseconds(20);
  for (int has_come = 0;;) {
    MPI_Test(&request, &has_come, MPI_STATUS_IGNORE);
    if (has_come != 0) break;
    if (Clock::now() - start > own_longest)
      end_job(
          fmt::format("process {} of {} has waited {:g} s for the others, and gives up "
                      "(OVOID_MPI_WAIT sets how long)",
                      number_, count_, longest.count()));
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
  meet_within(patience_, {}, 0);
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
  try {
    Picture picture = put_together_here(seen, look);
    if (number_ != 0) return std::nullopt;
    return picture;
  } catch (const TeamError&) {
    throw;
  } catch (const std::exception& error) {
    // The others wait for what will not come.
    end_job(fmt::format("process {} of {}: while pictures are exchanged: {}", number_, count_,
                        error.what()));
  }
}

Team::Picture MpiTeam::put_together_here(const DeepImage& seen, const Look& look) {
  const Stopwatch exchanging;
  Picture picture;
  const std::vector<DeepImage> from_all = exchanged(seen, number_, count_, &picture.bytes);
  picture.exchange_ms = exchanging.ms();
  const Stopwatch compositing;
  Image own;
  if (!from_all.empty()) own = composited(merged(from_all), look);
  picture.composite_ms = compositing.ms();
  meet({}, 0);
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
  if (kernels_ != nullptr) picture.bytes += kernels_->bytes_sent();
  std::int64_t bytes = 0;
  MPI_Reduce(&picture.bytes, &bytes, 1, MPI_INT64_T, MPI_SUM, 0, MPI_COMM_WORLD);
  picture.bytes = bytes;
  picture.exchange_ms = spread(picture.exchange_ms).greatest;
  picture.composite_ms = spread(picture.composite_ms).greatest;
  return picture;
}

}  // namespace ovoid::cli
