// SPDX-License-Identifier: Apache-2.0
#include "vtkOvoidVolumeMapper.h"

#include <vtkImageData.h>
#include <vtkObjectFactory.h>
#include <vtkRenderer.h>
#include <vtkVolume.h>

#include <algorithm>
#include <limits>

#include "volume_painter.h"

vtkStandardNewMacro(vtkOvoidVolumeMapper);

vtkOvoidVolumeMapper::vtkOvoidVolumeMapper()
    : Painter(std::make_unique<ovoid::mappers::VolumePainter>()) {
  this->SetOwnedBoundsToAll();
}
vtkOvoidVolumeMapper::~vtkOvoidVolumeMapper() = default;

// What both a frame and its field need; an error is told.
void vtkOvoidVolumeMapper::WithSettings(
    const std::function<void(const ovoid::mappers::MapperSettings&)>& use) {
  ovoid::mappers::MapperSettings settings;
  settings.arrays = {this->ScalarMode, this->ArrayAccessMode, this->ArrayId, this->ArrayName,
                     this->VectorMode, this->VectorComponent, true};
  settings.kernel = this->Kernel;
  settings.blend_mode = this->BlendMode;
  settings.backend = this->Backend;
  settings.num_threads = this->NumberOfThreads;
  settings.sample_distance = this->SampleDistance;
  settings.greatest_image_distance =
      this->AutoAdjustSampleDistances != 0 ? this->MaximumImageSampleDistance : 1.0;
  settings.clipping_planes = this->GetClippingPlanes();
  if (this->Cropping != 0) {
    auto& cropping = settings.cropping.emplace();
    std::copy_n(this->CroppingRegionPlanes, 6, cropping.planes.begin());
    cropping.regions = static_cast<unsigned>(this->CroppingRegionFlags);
  }
  settings.has_image_sheets = this->ImageSheets != 0;
  settings.owned = ovoid::mappers::owned_box(this->OwnedBounds);
  ovoid::mappers::draw_or_tell(
      [&] {
        if (this->GetNumberOfInputConnections(0) > 0) this->GetInputAlgorithm()->Update();
        use(settings);
      },
      [&](const char* what) { vtkErrorMacro(<< what); });
}

void vtkOvoidVolumeMapper::Render(vtkRenderer* ren, vtkVolume* vol) {
  this->WithSettings([&](const ovoid::mappers::MapperSettings& settings) {
    this->Painter->draw(ren, vol, this->GetDataSetInput(), settings);
  });
}

double* vtkOvoidVolumeMapper::GetBounds() {
  double* const bounds = this->Superclass::GetBounds();
  if (bounds != nullptr && ovoid::mappers::owned_box(this->OwnedBounds))
    ovoid::mappers::widen(bounds);
  return bounds;
}

bool vtkOvoidVolumeMapper::UpdateField(vtkVolume* vol) {
  this->FieldSampleDistance = 0;
  this->WithSettings([&](const ovoid::mappers::MapperSettings& settings) {
    this->Painter->prepare(vol, this->GetDataSetInput(), settings);
    this->FieldSampleDistance = this->Painter->field_distance(vol, settings);
  });
  return this->FieldSampleDistance > 0;
}

void vtkOvoidVolumeMapper::SetOwnedBoundsToAll() {
  constexpr double kEndless = std::numeric_limits<double>::infinity();
  this->SetOwnedBounds(-kEndless, kEndless, -kEndless, kEndless, -kEndless, kEndless);
}

void vtkOvoidVolumeMapper::ReleaseGraphicsResources(vtkWindow* window) {
  this->Painter->release(window);
}

double vtkOvoidVolumeMapper::GetImageSampleDistance() { return this->Painter->image_distance(); }
double vtkOvoidVolumeMapper::GetRenderTime() { return this->Painter->times().all; }
double vtkOvoidVolumeMapper::GetFrameTime() { return this->Painter->times().renderer; }
double vtkOvoidVolumeMapper::GetDisplayTime() { return this->Painter->times().screen; }
int vtkOvoidVolumeMapper::GetFieldKernel() { return this->Painter->field_kernel(); }
vtkMTimeType vtkOvoidVolumeMapper::GetFieldTime() { return this->Painter->field_time(); }
bool vtkOvoidVolumeMapper::GetSharesMemory() { return this->Painter->shares_memory(); }
vtkTypeInt64 vtkOvoidVolumeMapper::GetFieldMemory() { return this->Painter->field_bytes(); }

void vtkOvoidVolumeMapper::GetColorImage(vtkImageData* image) {
  ovoid::mappers::copy_colors(*this->Painter, image);
}

void vtkOvoidVolumeMapper::GetDepthImage(vtkImageData* image) {
  ovoid::mappers::copy_depths(*this->Painter, image);
}

void vtkOvoidVolumeMapper::PrintSelf(ostream& os, vtkIndent indent) {
  this->Superclass::PrintSelf(os, indent);
  os << indent << "VectorMode: " << this->VectorMode << "\n"
     << indent << "VectorComponent: " << this->VectorComponent << "\n"
     << indent << "Kernel: " << this->Kernel << "\n"
     << indent << "Backend: " << this->Backend << "\n"
     << indent << "NumberOfThreads: " << this->NumberOfThreads << "\n"
     << indent << "SampleDistance: " << this->SampleDistance << "\n"
     << indent << "AutoAdjustSampleDistances: " << this->AutoAdjustSampleDistances << "\n"
     << indent << "MaximumImageSampleDistance: " << this->MaximumImageSampleDistance << "\n"
     << indent << "ImageSheets: " << this->ImageSheets << "\n"
     << indent << "OwnedBounds: " << this->OwnedBounds[0] << " to " << this->OwnedBounds[1] << ", "
     << this->OwnedBounds[2] << " to " << this->OwnedBounds[3] << ", " << this->OwnedBounds[4]
     << " to " << this->OwnedBounds[5] << "\n";
}
