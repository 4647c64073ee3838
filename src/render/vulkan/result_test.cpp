// SPDX-License-Identifier: Apache-2.0
#include "render/vulkan/result.h"

#include <gtest/gtest.h>

#include <string>

#include "ovoid/error.h"

namespace ovoid::vulkan {
namespace result_test {

// Each way in which a driver may fail has its code, and says what was tried and what else there is.
TEST(VulkanResult, FailuresAreErrorsWithAWayBack) {
  EXPECT_NO_THROW(check(VK_SUCCESS, "nothing"));
  EXPECT_NO_THROW(check(VK_INCOMPLETE, "nothing"));
  struct Case {
    VkResult result;
    ErrorCode code;
    const char* says;
  };
  for (const Case& failure :
       {Case{VK_ERROR_DEVICE_LOST, ErrorCode::kDeviceLost, "the next picture starts it anew"},
        Case{VK_ERROR_OUT_OF_DEVICE_MEMORY, ErrorCode::kOutOfMemory, "backend cpu"},
        Case{VK_ERROR_OUT_OF_HOST_MEMORY, ErrorCode::kOutOfMemory, "backend cpu"},
        Case{VK_ERROR_INITIALIZATION_FAILED, ErrorCode::kUnsupported, "VkResult -3"}}) {
    try {
      check(failure.result, "a test");
      ADD_FAILURE() << failure.says;
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), failure.code);
      EXPECT_NE(std::string(error.what()).find(failure.says), std::string::npos) << error.what();
      EXPECT_NE(std::string(error.what()).find("a test"), std::string::npos) << error.what();
    }
  }
}

}  // namespace result_test
}  // namespace ovoid::vulkan
