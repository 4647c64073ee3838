// SPDX-License-Identifier: Apache-2.0
#include "vtkOvoidGridRepresentation.h"

#include <vtkBoundingBox.h>
#include <vtkColorTransferFunction.h>
#include <vtkDataSetAttributes.h>
#include <vtkImageData.h>
#include <vtkInformation.h>
#include <vtkInformationVector.h>
#include <vtkNew.h>
#include <vtkObjectFactory.h>
#include <vtkOutlineSource.h>
#include <vtkPVLODVolume.h>
#include <vtkPVView.h>
#include <vtkRectilinearGrid.h>
#include <vtkStreamingDemandDrivenPipeline.h>
#include <vtkUnsignedCharArray.h>
#include <vtkVolume.h>
#include <vtkVolumeProperty.h>

#include <algorithm>
#include <limits>
#include <vector>

#include "ranks.h"
#include "vtkOvoidVolumeMapper.h"

namespace {

// Of neighbours' samples: kernels reach two, and the coefficients of the B-spline through samples
// depend on those farther away by 0.27 for each step: 8 steps leave 3e-5.
constexpr int kGhostLevels = 10;

// The bounds of the cells that no other rank has.
void bounds_of_own_cells(vtkDataSet* grid, double bounds[6]) {
  vtkUnsignedCharArray* const flags = grid->GetCellGhostArray();
  vtkBoundingBox own;
  for (vtkIdType c = 0; c < grid->GetNumberOfCells(); ++c) {
    if ((flags->GetValue(c) & vtkDataSetAttributes::DUPLICATECELL) != 0) continue;
    double of_cell[6];
    grid->GetCellBounds(c, of_cell);
    own.AddBounds(of_cell);
  }
  own.GetBounds(bounds);
}

}  // namespace

vtkStandardNewMacro(vtkOvoidGridRepresentation);

vtkOvoidGridRepresentation::vtkOvoidGridRepresentation() {
  this->VolumeMapper.TakeReference(vtkOvoidVolumeMapper::New());
}

vtkOvoidGridRepresentation::~vtkOvoidGridRepresentation() = default;

vtkOvoidVolumeMapper* vtkOvoidGridRepresentation::Mapper() {
  return vtkOvoidVolumeMapper::SafeDownCast(this->VolumeMapper);
}

void vtkOvoidGridRepresentation::SetKernel(int kernel) {
  this->Kernel = kernel;
  this->MarkModified();
}
void vtkOvoidGridRepresentation::SetImageSheets(bool has_image_sheets) {
  this->ImageSheets = has_image_sheets;
}
void vtkOvoidGridRepresentation::SetSampleDistance(double distance) {
  this->SampleDistance = distance;
}
void vtkOvoidGridRepresentation::SetBackend(int backend) { this->Mapper()->SetBackend(backend); }
void vtkOvoidGridRepresentation::SetNumberOfThreads(int threads) {
  this->Mapper()->SetNumberOfThreads(threads);
}

int vtkOvoidGridRepresentation::RequestUpdateExtent(vtkInformation* request,
                                                    vtkInformationVector** inputVector,
                                                    vtkInformationVector* outputVector) {
  const int result = this->Superclass::RequestUpdateExtent(request, inputVector, outputVector);
  const auto levels = vtkStreamingDemandDrivenPipeline::UPDATE_NUMBER_OF_GHOST_LEVELS();
  if (ovoid::paraview::has_several_ranks() &&
      inputVector[0]->GetNumberOfInformationObjects() == 1) {
    vtkInformation* const input = inputVector[0]->GetInformationObject(0);
    input->Set(levels, std::max(kGhostLevels, input->Get(levels)));
  }
  return result;
}

// The superclass leaves neighbours' samples out; they come back here, but for the bounds.
int vtkOvoidGridRepresentation::RequestData(vtkInformation* request,
                                            vtkInformationVector** inputVector,
                                            vtkInformationVector* outputVector) {
  const int result = this->Superclass::RequestData(request, inputVector, outputVector);
  if (inputVector[0]->GetNumberOfInformationObjects() != 1) return result;
  auto* const input = vtkDataSet::GetData(inputVector[0], 0);
  if (input == nullptr || !input->HasAnyGhostCells()) return result;
  const auto whole = vtkSmartPointer<vtkDataSet>::Take(input->NewInstance());
  whole->ShallowCopy(input);
  this->Cache = whole;
  this->DataSize = whole->GetActualMemorySize();
  double bounds[6];
  bounds_of_own_cells(whole, bounds);
  this->OutlineSource->SetBounds(bounds);
  this->OutlineSource->Update();
  std::copy_n(bounds, 6, this->DataBounds);
  return result;
}

int vtkOvoidGridRepresentation::ProcessViewRequest(vtkInformationRequestKey* request_type,
                                                   vtkInformation* inInfo,
                                                   vtkInformation* outInfo) {
  if (this->Superclass::ProcessViewRequest(request_type, inInfo, outInfo) == 0) return 0;
  // Owned bounds make the mapper's wider, and cameras go by those that it has after an update.
  if (request_type == vtkPVView::REQUEST_UPDATE()) this->Mapper()->SetOwnedBoundsToAll();
  if (request_type == vtkPVView::REQUEST_RENDER()) this->JoinRanks();
  return 1;
}

// The mapper has this rank's samples and those around them, and is told what boxes need to join.
void vtkOvoidGridRepresentation::JoinRanks() {
  vtkOvoidVolumeMapper* const mapper = this->Mapper();
  mapper->SetKernel(this->Kernel);
  mapper->SetImageSheets(this->ImageSheets ? 1 : 0);
  mapper->SetSampleDistance(this->SampleDistance);
  mapper->SetOwnedBoundsToAll();
  const std::vector<vtkBoundingBox> boxes = ovoid::paraview::boxes_of_ranks(this->GetView());
  if (boxes.empty()) return;
  mapper->SetImageSheets(1);
  mapper->SetAutoAdjustSampleDistances(0);
  double distance = std::numeric_limits<double>::infinity();
  int kernel = vtkOvoidVolumeMapper::AUTO_KERNEL;
  auto* const samples = vtkDataSet::SafeDownCast(mapper->GetInputDataObject(0, 0));
  if (samples != nullptr && samples->GetNumberOfPoints() > 0) {
    mapper->SetOwnedBounds(ovoid::paraview::owned_bounds(boxes, this->Actor->GetMatrix()).data());
    vtkNew<vtkVolume> volume;
    volume->SetProperty(this->Property);
    volume->SetUserMatrix(this->Actor->GetMatrix());
    if (mapper->UpdateField(volume)) {
      distance = mapper->GetFieldSampleDistance();
      kernel = mapper->GetFieldKernel();
    }
  } else {
    this->Actor->SetMapper(nullptr);
  }
  distance = ovoid::paraview::least_of_ranks(distance);
  if (this->SampleDistance == 0 && distance < std::numeric_limits<double>::infinity())
    mapper->SetSampleDistance(distance);
  // Labels keep a kernel of their own only where every rank has taken its samples for labels.
  const bool has_bspline =
      ovoid::paraview::greatest_of_ranks(kernel == vtkOvoidVolumeMapper::BSPLINE ? 1 : 0) > 0;
  if (this->Kernel == vtkOvoidVolumeMapper::AUTO_KERNEL && has_bspline)
    mapper->SetKernel(vtkOvoidVolumeMapper::BSPLINE);
}

// What ParaView tells its own mappers by their classes.
void vtkOvoidGridRepresentation::UpdateMapperParameters() {
  this->Superclass::UpdateMapperParameters();
  vtkOvoidVolumeMapper* const mapper = this->Mapper();
  vtkColorTransferFunction* const colors = this->Property->GetRGBTransferFunction(0);
  if (this->Property->GetIndependentComponents() != 0) {
    mapper->SetVectorMode(colors->GetVectorMode() == vtkScalarsToColors::MAGNITUDE
                              ? vtkOvoidVolumeMapper::MAGNITUDE
                              : vtkOvoidVolumeMapper::COMPONENT);
    mapper->SetVectorComponent(colors->GetVectorComponent());
  } else {
    mapper->SetVectorMode(vtkOvoidVolumeMapper::DISABLED);
  }
}

void vtkOvoidGridRepresentation::PrintSelf(ostream& os, vtkIndent indent) {
  this->Superclass::PrintSelf(os, indent);
  os << indent << "Kernel: " << this->Kernel << "\n"
     << indent << "ImageSheets: " << this->ImageSheets << "\n"
     << indent << "SampleDistance: " << this->SampleDistance << "\n";
}
