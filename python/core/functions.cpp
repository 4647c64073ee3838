// SPDX-License-Identifier: Apache-2.0
#include "functions.h"

#include <fmt/format.h>

#include "conversion.h"
#include "load.h"
#include "make_fit.h"
#include "make_simplified.h"
#include "ovoid/error.h"
#include "scene.h"

namespace ovoid::python {
namespace {

using cli::Session;
using cli::Words;

}  // namespace

std::vector<cli::FlagForm> forms_of(const std::string& command) {
  if (command == "fit") {
    cli::FitFlags into;
    return cli::make_fit_flags(&into).forms();
  }
  if (command == "simplify") {
    cli::SimplifyFlags into;
    return cli::make_simplify_flags(&into).forms();
  }
  if (command == "convert") {
    cli::ConvertFlags into;
    return cli::make_convert_flags(&into).forms();
  }
  if (command != "render")
    throw Error(ErrorCode::kInvalidArgument, fmt::format("no settings of '{}'", command));
  cli::DataFlags data;
  cli::DrawingFlags drawing;
  return DrawFlags(&data, &drawing).forms();
}

std::string fit(const Source& source, const Words& words, Work& work) {
  cli::FitFlags into;
  cli::Flags flags = cli::make_fit_flags(&into);
  parse(source, words, flags, into.data);
  cli::check_fit_flags(into);
  cli::take_from_model(&into.data, &into.model);
  Session session = session_of(work);
  const Dataset dataset = cli::load(into.data, session);
  const cli::Stopwatch watch;
  const FitReport report = cli::make_fit(dataset, flags, into, session, progress_of(work));
  return cli::json_of(report, watch.ms() / 1000).dump();
}

std::string simplify(const Source& source, const Words& words, Work& work) {
  cli::SimplifyFlags into;
  cli::Flags flags = cli::make_simplify_flags(&into);
  parse(source, words, flags, into.data);
  cli::check_simplify_flags(into);
  cli::take_from_model(&into.data, &into.model);
  Session session = session_of(work);
  const Dataset dataset = cli::load(into.data, session);
  const cli::Simplified done =
      cli::make_simplified(dataset, flags, into, session, progress_of(work));
  return cli::json_of(done).dump();
}

Dataset convert(const Source& source, const Words& words, Work& work) {
  cli::ConvertFlags into;
  cli::Flags flags = cli::make_convert_flags(&into);
  parse(source, words, flags, into.data);
  cli::take_from_model(&into.data, &into.model);
  Session session = session_of(work);
  return cli::converted(into, flags, cli::load(into.data, session), session);
}

}  // namespace ovoid::python
