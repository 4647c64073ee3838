// SPDX-License-Identifier: Apache-2.0
#include "vtkOvoidMeshRepresentation.h"

#include <vtkColorTransferFunction.h>
#include <vtkNew.h>
#include <vtkObjectFactory.h>
#include <vtkVolumeProperty.h>
#include <vtkVolumeRepresentationPreprocessor.h>

#include "vtkOvoidUnstructuredGridVolumeMapper.h"

namespace {

constexpr const char* kName = "Ovoid";

}  // namespace

vtkStandardNewMacro(vtkOvoidMeshRepresentation);

vtkOvoidMeshRepresentation::vtkOvoidMeshRepresentation() {
  this->Preprocessor->SetTetrahedraOnly(0);
  vtkNew<vtkOvoidUnstructuredGridVolumeMapper> mapper;
  this->AddVolumeMapper(kName, mapper);
  this->Superclass::SetActiveVolumeMapper(kName);
}

vtkOvoidMeshRepresentation::~vtkOvoidMeshRepresentation() = default;

void vtkOvoidMeshRepresentation::SetActiveVolumeMapper(const char*) {}

void vtkOvoidMeshRepresentation::SetShade(bool shade) {
  this->Property->SetShade(static_cast<int>(shade));
}

// What ParaView tells its own mappers by their classes.
void vtkOvoidMeshRepresentation::UpdateMapperParameters() {
  this->Superclass::UpdateMapperParameters();
  auto* const mapper =
      vtkOvoidUnstructuredGridVolumeMapper::SafeDownCast(this->GetActiveVolumeMapper());
  vtkColorTransferFunction* const colors = this->Property->GetRGBTransferFunction(0);
  if (this->Property->GetIndependentComponents() != 0) {
    mapper->SetVectorMode(colors->GetVectorMode() == vtkScalarsToColors::MAGNITUDE
                              ? vtkOvoidUnstructuredGridVolumeMapper::MAGNITUDE
                              : vtkOvoidUnstructuredGridVolumeMapper::COMPONENT);
    mapper->SetVectorComponent(colors->GetVectorComponent());
  } else {
    mapper->SetVectorMode(vtkOvoidUnstructuredGridVolumeMapper::DISABLED);
  }
}

void vtkOvoidMeshRepresentation::PrintSelf(ostream& os, vtkIndent indent) {
  this->Superclass::PrintSelf(os, indent);
}
