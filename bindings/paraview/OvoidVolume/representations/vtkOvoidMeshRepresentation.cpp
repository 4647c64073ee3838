// SPDX-License-Identifier: Apache-2.0
#include "vtkOvoidMeshRepresentation.h"

#include <vtkAlgorithmOutput.h>
#include <vtkBoundingBox.h>
#include <vtkColorTransferFunction.h>
#include <vtkInformation.h>
#include <vtkInformationVector.h>
#include <vtkMath.h>
#include <vtkNew.h>
#include <vtkObjectFactory.h>
#include <vtkPVLODVolume.h>
#include <vtkPVRenderView.h>
#include <vtkTimeStamp.h>
#include <vtkUnstructuredGrid.h>
#include <vtkVolume.h>
#include <vtkVolumeProperty.h>
#include <vtkVolumeRepresentationPreprocessor.h>

#include <algorithm>
#include <vector>

#include "cells_of_any.h"
#include "ranks.h"
#include "vtkOvoidUnstructuredGridVolumeMapper.h"

namespace {

constexpr const char* kName = "Ovoid";

}  // namespace

vtkStandardNewMacro(vtkOvoidMeshRepresentation);

vtkOvoidMeshRepresentation::vtkOvoidMeshRepresentation()
    : Mapper(vtkSmartPointer<vtkOvoidUnstructuredGridVolumeMapper>::New()) {
  this->Preprocessor->SetTetrahedraOnly(0);
  this->AddVolumeMapper(kName, this->Mapper);
  this->Superclass::SetActiveVolumeMapper(kName);
}

vtkOvoidMeshRepresentation::~vtkOvoidMeshRepresentation() = default;

void vtkOvoidMeshRepresentation::SetActiveVolumeMapper(const char*) {}

void vtkOvoidMeshRepresentation::SetShade(bool shade) {
  this->Property->SetShade(static_cast<int>(shade));
}
void vtkOvoidMeshRepresentation::SetAmbient(double ambient) { this->Property->SetAmbient(ambient); }
void vtkOvoidMeshRepresentation::SetDiffuse(double diffuse) { this->Property->SetDiffuse(diffuse); }
void vtkOvoidMeshRepresentation::SetSpecular(double specular) {
  this->Property->SetSpecular(specular);
}
void vtkOvoidMeshRepresentation::SetSpecularPower(double power) {
  this->Property->SetSpecularPower(power);
}

void vtkOvoidMeshRepresentation::SetSampleDistance(double distance) {
  this->SampleDistance = distance;
}
void vtkOvoidMeshRepresentation::SetBackend(int backend) { this->Mapper->SetBackend(backend); }
void vtkOvoidMeshRepresentation::SetNumberOfThreads(int threads) {
  this->Mapper->SetNumberOfThreads(threads);
}

int vtkOvoidMeshRepresentation::FillInputPortInformation(int, vtkInformation* info) {
  info->Set(vtkAlgorithm::INPUT_REQUIRED_DATA_TYPE(), "vtkDataSet");
  info->Append(vtkAlgorithm::INPUT_REQUIRED_DATA_TYPE(), "vtkCompositeDataSet");
  info->Set(vtkAlgorithm::INPUT_IS_OPTIONAL(), 1);
  return 1;
}

// As the superclass does, of data that it does not take.
int vtkOvoidMeshRepresentation::RequestData(vtkInformation* request,
                                            vtkInformationVector** inputVector,
                                            vtkInformationVector* outputVector) {
  vtkSmartPointer<vtkUnstructuredGrid> cells;
  if (inputVector[0]->GetNumberOfInformationObjects() == 1)
    cells = ovoid::paraview::cells_of_any(vtkDataObject::GetData(inputVector[0], 0));
  if (cells == nullptr) return this->Superclass::RequestData(request, inputVector, outputVector);
  vtkMath::UninitializeBounds(this->DataBounds);
  this->Preprocessor->SetInputDataObject(cells);
  this->Preprocessor->Modified();
  this->Preprocessor->Update();
  cells->GetBounds(this->DataBounds);
  return this->vtkVolumeRepresentation::RequestData(request, inputVector, outputVector);
}

int vtkOvoidMeshRepresentation::ProcessViewRequest(vtkInformationRequestKey* request_type,
                                                   vtkInformation* inInfo,
                                                   vtkInformation* outInfo) {
  if (this->Superclass::ProcessViewRequest(request_type, inInfo, outInfo) == 0) return 0;
  // Owned bounds make the mapper's wider, and cameras go by those that it has after an update.
  if (request_type == vtkPVView::REQUEST_UPDATE()) this->Mapper->SetOwnedBoundsToAll();
  if (request_type == vtkPVView::REQUEST_RENDER()) this->JoinRanks();
  return 1;
}

// This rank's cells, or none, with those around them that its box needs.
void vtkOvoidMeshRepresentation::UpdateJoined(vtkDataObject* own_cells,
                                              const std::vector<vtkBoundingBox>& boxes) {
  vtkNew<vtkUnstructuredGrid> none;
  auto* own = vtkUnstructuredGrid::SafeDownCast(own_cells);
  if (own == nullptr) own = none;
  const bool is_due = this->Joined == nullptr || own->GetMTime() > this->JoinedTime;
  if (!(ovoid::paraview::greatest_of_ranks(is_due ? 1 : 0) > 0)) return;
  this->Joined = ovoid::paraview::with_neighbours(own, boxes);
  vtkTimeStamp now;
  now.Modified();
  this->JoinedTime = now.GetMTime();
}

// The mapper has the cells that ParaView gave to this rank, and is told what boxes need to join. A
// single rank has the sheets that several would have.
void vtkOvoidMeshRepresentation::JoinRanks() {
  this->Mapper->SetSampleDistance(this->SampleDistance);
  this->Mapper->SetOwnedBoundsToAll();
  auto* cells = vtkUnstructuredGrid::SafeDownCast(this->Mapper->GetInputDataObject(0, 0));
  const std::vector<vtkBoundingBox> boxes = ovoid::paraview::boxes_of_ranks(this->GetView());
  if (boxes.empty()) {
    this->Joined = nullptr;
  } else {
    this->UpdateJoined(cells, boxes);
    cells = this->Joined;
    this->Mapper->SetInputDataObject(0, cells);
    this->Mapper->SetOwnedBounds(
        ovoid::paraview::owned_bounds(boxes, this->Actor->GetMatrix()).data());
    this->Mapper->SetAutoAdjustSampleDistances(0);
  }
  std::vector<double> sums(5);
  if (cells == nullptr || cells->GetNumberOfCells() == 0) {
    this->Actor->SetMapper(nullptr);
  } else if (this->SampleDistance == 0 && this->Actor->GetMapper() != nullptr) {
    vtkNew<vtkVolume> volume;
    volume->SetProperty(this->Property);
    volume->SetUserMatrix(this->Actor->GetMatrix());
    if (this->Mapper->UpdateField(volume))
      std::copy_n(this->Mapper->GetFieldSums(), sums.size(), sums.begin());
  }
  if (!boxes.empty()) sums = ovoid::paraview::sums_of_ranks(sums);
  if (this->SampleDistance == 0)
    this->Mapper->SetSampleDistance(
        vtkOvoidUnstructuredGridVolumeMapper::SampleDistanceOf(sums.data()));
}

// What ParaView tells its own mappers by their classes.
void vtkOvoidMeshRepresentation::UpdateMapperParameters() {
  this->Superclass::UpdateMapperParameters();
  vtkColorTransferFunction* const colors = this->Property->GetRGBTransferFunction(0);
  if (this->Property->GetIndependentComponents() != 0) {
    this->Mapper->SetVectorMode(colors->GetVectorMode() == vtkScalarsToColors::MAGNITUDE
                                    ? vtkOvoidUnstructuredGridVolumeMapper::MAGNITUDE
                                    : vtkOvoidUnstructuredGridVolumeMapper::COMPONENT);
    this->Mapper->SetVectorComponent(colors->GetVectorComponent());
  } else {
    this->Mapper->SetVectorMode(vtkOvoidUnstructuredGridVolumeMapper::DISABLED);
  }
}

void vtkOvoidMeshRepresentation::PrintSelf(ostream& os, vtkIndent indent) {
  this->Superclass::PrintSelf(os, indent);
  os << indent << "SampleDistance: " << this->SampleDistance << "\n";
}
