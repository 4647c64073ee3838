// SPDX-License-Identifier: Apache-2.0
/**
 * @class   vtkOvoidMeshRepresentation
 * @brief   meshes, adaptive grids and points as volumes that Ovoid draws
 *
 * ParaView's own representation of unstructured volumes with another mapper: of cells of any kind,
 * which are not cut into tetrahedra, and lit. Takes structured and adaptive grids
 * (vtkUniformGridAMR) and the points of vtkPolyData, too. With several ranks each draws the box
 * that ParaView gives it, with the cells of its neighbours around it, so that boxes join.
 */
#pragma once

#include <vtkSmartPointer.h>

#include <vector>

#include "vtkOvoidRepresentationsModule.h"
#include "vtkUnstructuredGridVolumeRepresentation.h"

class vtkOvoidUnstructuredGridVolumeMapper;
class vtkBoundingBox;
class vtkUnstructuredGrid;

class VTKOVOIDREPRESENTATIONS_EXPORT vtkOvoidMeshRepresentation
    : public vtkUnstructuredGridVolumeRepresentation {
 public:
  static vtkOvoidMeshRepresentation* New();
  // clang-format off
  vtkTypeMacro(vtkOvoidMeshRepresentation, vtkUnstructuredGridVolumeRepresentation)
      // clang-format on
      void PrintSelf(ostream& os, vtkIndent indent) override;

  /**
   * There is one mapper: the name is not read.
   */
  void SetActiveVolumeMapper(const char* name) override;

  ///@{
  /**
   * Light, as of images' volumes.
   */
  void SetShade(bool shade);
  void SetAmbient(double ambient);
  void SetDiffuse(double diffuse);
  void SetSpecular(double specular);
  void SetSpecularPower(double power);
  ///@}

  ///@{
  /**
   * The mapper's: SampleDistance (0: as the data need it), Backend, NumberOfThreads.
   */
  void SetSampleDistance(double distance);
  void SetBackend(int backend);
  void SetNumberOfThreads(int threads);
  ///@}

  int ProcessViewRequest(vtkInformationRequestKey* request_type, vtkInformation* inInfo,
                         vtkInformation* outInfo) override;

 protected:
  vtkOvoidMeshRepresentation();
  ~vtkOvoidMeshRepresentation() override;

  int FillInputPortInformation(int port, vtkInformation* info) override;
  int RequestData(vtkInformation* request, vtkInformationVector** inputVector,
                  vtkInformationVector* outputVector) override;
  void UpdateMapperParameters() override;

 private:
  vtkOvoidMeshRepresentation(const vtkOvoidMeshRepresentation&) = delete;
  void operator=(const vtkOvoidMeshRepresentation&) = delete;

  void UpdateJoined(vtkDataObject* own_cells, const std::vector<vtkBoundingBox>& boxes);
  void JoinRanks();

  vtkSmartPointer<vtkOvoidUnstructuredGridVolumeMapper> Mapper;
  double SampleDistance = 0;
  vtkSmartPointer<vtkUnstructuredGrid> Joined;  // this rank's cells and those around them
  vtkMTimeType JoinedTime = 0;
};
