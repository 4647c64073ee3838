// SPDX-License-Identifier: Apache-2.0
/**
 * @class   vtkOvoidGridRepresentation
 * @brief   images and rectilinear grids as volumes that Ovoid draws
 *
 * ParaView's own representation of volumes with another mapper: its properties and transfer
 * functions are those of "Volume". With several ranks each asks for samples of its neighbours, and
 * draws the box that is its own, so that boxes join.
 */
#pragma once

#include "vtkImageVolumeRepresentation.h"
#include "vtkOvoidRepresentationsModule.h"

class vtkOvoidVolumeMapper;

class VTKOVOIDREPRESENTATIONS_EXPORT vtkOvoidGridRepresentation
    : public vtkImageVolumeRepresentation {
 public:
  static vtkOvoidGridRepresentation* New();
  // clang-format off
  vtkTypeMacro(vtkOvoidGridRepresentation, vtkImageVolumeRepresentation)
      // clang-format on
      void PrintSelf(ostream& os, vtkIndent indent) override;

  /**
   * What stands at every sample: vtkOvoidVolumeMapper::KernelType.
   */
  void SetKernel(int kernel);

  ///@{
  /**
   * The mapper's: ImageSheets, SampleDistance (0: as the data need it), Backend, NumberOfThreads.
   * Of several ranks sheets are the image's in any case.
   */
  void SetImageSheets(bool has_image_sheets);
  void SetSampleDistance(double distance);
  void SetBackend(int backend);
  void SetNumberOfThreads(int threads);
  ///@}

  int ProcessViewRequest(vtkInformationRequestKey* request_type, vtkInformation* inInfo,
                         vtkInformation* outInfo) override;

 protected:
  vtkOvoidGridRepresentation();
  ~vtkOvoidGridRepresentation() override;

  int RequestUpdateExtent(vtkInformation* request, vtkInformationVector** inputVector,
                          vtkInformationVector* outputVector) override;
  int RequestData(vtkInformation* request, vtkInformationVector** inputVector,
                  vtkInformationVector* outputVector) override;
  void UpdateMapperParameters() override;

 private:
  vtkOvoidGridRepresentation(const vtkOvoidGridRepresentation&) = delete;
  void operator=(const vtkOvoidGridRepresentation&) = delete;

  void JoinRanks();
  vtkOvoidVolumeMapper* Mapper();

  int Kernel = 0;
  bool ImageSheets = false;
  double SampleDistance = 0;
};
