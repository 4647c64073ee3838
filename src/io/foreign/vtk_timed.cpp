// SPDX-License-Identifier: Apache-2.0
#ifdef OVOID_IO_VTK

#include "io/foreign/vtk_timed.h"

#include <vtkAlgorithm.h>
#include <vtkDataObject.h>
#include <vtkInformation.h>
#include <vtkInformationDoubleVectorKey.h>
#include <vtkStreamingDemandDrivenPipeline.h>

#include <algorithm>
#include <utility>

#include "io/foreign/vtk_mesh.h"
#include "io/foreign/vtk_reading.h"
#include "io/meshes/mesh_steps.h"

namespace ovoid::io {

Dataset read_timed(const ByteSource& source, const std::string& format, vtkAlgorithm* reader,
                   const ReadOptions& options, const std::function<void()>& set_up,
                   const std::function<std::string(const std::string&)>& rename) {
  VtkRun run(source, options);
  std::vector<double> times;
  run(reader, [&] {
    reader->UpdateInformation();
    vtkInformation* const information = reader->GetOutputInformation(0);
    const auto key = vtkStreamingDemandDrivenPipeline::TIME_STEPS();
    if (information != nullptr && information->Has(key) != 0) {
      const double* const values = information->Get(key);
      times.assign(values, values + information->Length(key));
    }
  });
  if (set_up) set_up();
  const auto num_steps = std::max<std::int64_t>(1, static_cast<std::int64_t>(times.size()));
  return read_mesh_step(source.name(), num_steps, times, options, [&](std::int64_t step) {
    run.notes.clear();
    run(reader, [&] {
      if (times.empty())
        reader->Update();
      else
        reader->UpdateTimeStep(times[static_cast<std::size_t>(step)]);
    });
    Dataset dataset;
    dataset.source = source.name();
    dataset.format = format;
    dataset.notes = run.notes;
    auto parts = parts_of(source.name(), reader->GetOutputDataObject(0), dataset.notes);
    for (MeshPart& part : parts) {
      if (rename) part.block = rename(part.block);
      part.time.reset();  // the step's own
    }
    return mesh_of_parts(std::move(dataset), std::move(parts), options);
  });
}

}  // namespace ovoid::io

#endif
