# Compiler settings that hold for every target of the house, and the libraries the house stands on.
include(GNUInstallDirs)
set(CMAKE_INSTALL_DEFAULT_COMPONENT_NAME gateway)
set(CMAKE_SKIP_INSTALL_ALL_DEPENDENCY ON)  # to install and to pack, no test needs to be built

option(MOTIONLAB_TESTS "Build the tests" ON)
option(MOTIONLAB_WERROR "Treat warnings as errors" ON)
set(MOTIONLAB_SANITIZE "" CACHE STRING "Sanitizers, e.g. address,undefined or thread")

set(CMAKE_CXX_STANDARD 20)
set(CMAKE_CXX_STANDARD_REQUIRED ON)
set(CMAKE_CXX_EXTENSIONS OFF)
set(CMAKE_EXPORT_COMPILE_COMMANDS ON)
set(CMAKE_POSITION_INDEPENDENT_CODE ON)
if(NOT CMAKE_BUILD_TYPE)
  set(CMAKE_BUILD_TYPE Release CACHE STRING "" FORCE)
endif()
find_program(MOTIONLAB_CCACHE ccache)
if(MOTIONLAB_CCACHE)
  set(CMAKE_CXX_COMPILER_LAUNCHER ${MOTIONLAB_CCACHE})
endif()

add_library(motionlab_flags INTERFACE)
target_include_directories(motionlab_flags INTERFACE ${PROJECT_SOURCE_DIR})
target_compile_options(motionlab_flags INTERFACE
  -Wall -Wextra -Wpedantic -Wshadow -Wconversion -Wnon-virtual-dtor
  -ffp-contract=off  # golden reruns are bit-equal on x86-64
  $<$<BOOL:${MOTIONLAB_WERROR}>:-Werror>)
if(MOTIONLAB_SANITIZE)
  target_compile_options(motionlab_flags INTERFACE -fsanitize=${MOTIONLAB_SANITIZE} -fno-omit-frame-pointer
                         -fno-sanitize-recover=all)
  target_link_options(motionlab_flags INTERFACE -fsanitize=${MOTIONLAB_SANITIZE})
  if(MOTIONLAB_SANITIZE MATCHES thread)
    # The race detector does not understand fences, and every io_context of ours runs on one thread.
    target_compile_definitions(motionlab_flags INTERFACE BOOST_ASIO_DISABLE_FENCED_BLOCK)
  endif()
endif()

find_package(Threads REQUIRED)
find_package(Eigen3 3.4 REQUIRED NO_MODULE)
find_package(Boost 1.74 REQUIRED)
find_package(spdlog REQUIRED)
find_package(tomlplusplus REQUIRED)
find_package(nlohmann_json REQUIRED)
find_package(CLI11 REQUIRED)
find_package(PkgConfig REQUIRED)
pkg_check_modules(SYSTEMD REQUIRED IMPORTED_TARGET libsystemd)
