// SPDX-License-Identifier: Apache-2.0
#include "vtkOvoidGridRepresentation.h"

#include <vtkColorTransferFunction.h>
#include <vtkNew.h>
#include <vtkObjectFactory.h>
#include <vtkVolumeProperty.h>

#include "vtkOvoidVolumeMapper.h"

vtkStandardNewMacro(vtkOvoidGridRepresentation);

vtkOvoidGridRepresentation::vtkOvoidGridRepresentation() {
  this->VolumeMapper.TakeReference(vtkOvoidVolumeMapper::New());
}

vtkOvoidGridRepresentation::~vtkOvoidGridRepresentation() = default;

void vtkOvoidGridRepresentation::SetKernel(int kernel) {
  vtkOvoidVolumeMapper::SafeDownCast(this->VolumeMapper)->SetKernel(kernel);
  this->MarkModified();
}

// What ParaView tells its own mappers by their classes.
void vtkOvoidGridRepresentation::UpdateMapperParameters() {
  this->Superclass::UpdateMapperParameters();
  auto* const mapper = vtkOvoidVolumeMapper::SafeDownCast(this->VolumeMapper);
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
}
