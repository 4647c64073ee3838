// SPDX-License-Identifier: Apache-2.0
#include "vtkOvoidUnstructuredGridVolumeMapper.h"

#include <vtkDataObject.h>
#include <vtkImageData.h>
#include <vtkInformation.h>
#include <vtkObjectFactory.h>
#include <vtkPointSet.h>
#include <vtkRenderer.h>
#include <vtkUnstructuredGridBase.h>
#include <vtkVolume.h>

#include <algorithm>
#include <limits>

#include "volume_painter.h"

vtkStandardNewMacro(vtkOvoidUnstructuredGridVolumeMapper);

vtkOvoidUnstructuredGridVolumeMapper::vtkOvoidUnstructuredGridVolumeMapper()
    : Painter(std::make_unique<ovoid::mappers::VolumePainter>()) {
  this->SetOwnedBoundsToAll();
}
vtkOvoidUnstructuredGridVolumeMapper::~vtkOvoidUnstructuredGridVolumeMapper() = default;

void vtkOvoidUnstructuredGridVolumeMapper::SetInputData(vtkUnstructuredGridBase* grid) {
  this->SetInputDataInternal(0, grid);
}

void vtkOvoidUnstructuredGridVolumeMapper::SetInputData(vtkDataSet* points) {
  if (points != nullptr && vtkPointSet::SafeDownCast(points) == nullptr) {
    vtkErrorMacro(<< "a " << points->GetClassName() << " is not drawn: expected a vtkPointSet");
    return;
  }
  this->SetInputDataInternal(0, points);
}

int vtkOvoidUnstructuredGridVolumeMapper::FillInputPortInformation(int,
                                                                   vtkInformation* information) {
  information->Set(vtkAlgorithm::INPUT_REQUIRED_DATA_TYPE(), "vtkPointSet");
  return 1;
}

// What both a frame and its field need; an error is told.
void vtkOvoidUnstructuredGridVolumeMapper::WithSettings(
    const std::function<void(const ovoid::mappers::MapperSettings&)>& use) {
  ovoid::mappers::MapperSettings settings;
  settings.arrays = {this->ScalarMode, this->ArrayAccessMode, this->ArrayId,
                     this->ArrayName,  this->VectorMode,      this->VectorComponent};
  settings.blend_mode = this->BlendMode;
  settings.backend = this->Backend;
  settings.num_threads = this->NumberOfThreads;
  settings.sample_distance = this->SampleDistance;
  settings.greatest_image_distance =
      this->AutoAdjustSampleDistances != 0 ? this->MaximumImageSampleDistance : 1.0;
  settings.clipping_planes = this->GetClippingPlanes();
  settings.owned = ovoid::mappers::owned_box(this->OwnedBounds);
  ovoid::mappers::draw_or_tell(
      [&] {
        if (this->GetNumberOfInputConnections(0) > 0) this->GetInputAlgorithm()->Update();
        use(settings);
      },
      [&](const char* what) { vtkErrorMacro(<< what); });
}

void vtkOvoidUnstructuredGridVolumeMapper::Render(vtkRenderer* ren, vtkVolume* vol) {
  this->WithSettings([&](const ovoid::mappers::MapperSettings& settings) {
    this->Painter->draw(ren, vol, this->GetDataSetInput(), settings);
  });
}

double* vtkOvoidUnstructuredGridVolumeMapper::GetBounds() {
  double* const bounds = this->Superclass::GetBounds();
  if (bounds != nullptr && ovoid::mappers::owned_box(this->OwnedBounds))
    ovoid::mappers::widen(bounds);
  return bounds;
}

bool vtkOvoidUnstructuredGridVolumeMapper::UpdateField(vtkVolume* vol) {
  bool is_made = false;
  this->WithSettings([&](const ovoid::mappers::MapperSettings& settings) {
    this->Painter->prepare(vol, this->GetDataSetInput(), settings);
    const ovoid::mappers::KernelSums& sums = this->Painter->field_sums(settings);
    std::copy(sums.begin(), sums.end(), this->FieldSums);
    is_made = true;
  });
  return is_made;
}

double vtkOvoidUnstructuredGridVolumeMapper::SampleDistanceOf(const double sums[5]) {
  ovoid::mappers::KernelSums all;
  std::copy_n(sums, all.size(), all.begin());
  return ovoid::mappers::sheet_distance_of(all);
}

void vtkOvoidUnstructuredGridVolumeMapper::SetOwnedBoundsToAll() {
  constexpr double kEndless = std::numeric_limits<double>::infinity();
  this->SetOwnedBounds(-kEndless, kEndless, -kEndless, kEndless, -kEndless, kEndless);
}

void vtkOvoidUnstructuredGridVolumeMapper::ReleaseGraphicsResources(vtkWindow* window) {
  this->Painter->release(window);
}

double vtkOvoidUnstructuredGridVolumeMapper::GetImageSampleDistance() {
  return this->Painter->image_distance();
}
double vtkOvoidUnstructuredGridVolumeMapper::GetRenderTime() { return this->Painter->times().all; }
double vtkOvoidUnstructuredGridVolumeMapper::GetFrameTime() {
  return this->Painter->times().renderer;
}
double vtkOvoidUnstructuredGridVolumeMapper::GetDisplayTime() {
  return this->Painter->times().screen;
}
vtkMTimeType vtkOvoidUnstructuredGridVolumeMapper::GetFieldTime() {
  return this->Painter->field_time();
}
vtkTypeInt64 vtkOvoidUnstructuredGridVolumeMapper::GetFieldMemory() {
  return this->Painter->field_bytes();
}

void vtkOvoidUnstructuredGridVolumeMapper::GetColorImage(vtkImageData* image) {
  ovoid::mappers::copy_colors(*this->Painter, image);
}

void vtkOvoidUnstructuredGridVolumeMapper::GetDepthImage(vtkImageData* image) {
  ovoid::mappers::copy_depths(*this->Painter, image);
}

void vtkOvoidUnstructuredGridVolumeMapper::PrintSelf(ostream& os, vtkIndent indent) {
  this->Superclass::PrintSelf(os, indent);
  os << indent << "VectorMode: " << this->VectorMode << "\n"
     << indent << "VectorComponent: " << this->VectorComponent << "\n"
     << indent << "Backend: " << this->Backend << "\n"
     << indent << "NumberOfThreads: " << this->NumberOfThreads << "\n"
     << indent << "SampleDistance: " << this->SampleDistance << "\n"
     << indent << "AutoAdjustSampleDistances: " << this->AutoAdjustSampleDistances << "\n"
     << indent << "MaximumImageSampleDistance: " << this->MaximumImageSampleDistance << "\n"
     << indent << "OwnedBounds: " << this->OwnedBounds[0] << " to " << this->OwnedBounds[1] << ", "
     << this->OwnedBounds[2] << " to " << this->OwnedBounds[3] << ", " << this->OwnedBounds[4]
     << " to " << this->OwnedBounds[5] << "\n";
}
