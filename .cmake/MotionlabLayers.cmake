# The layers of the house. A target links strictly downhill; two targets of one layer cannot see each other.
# Both the links and the quoted includes are checked when CMake configures.

set(MOTIONLAB_LAYER_NAMES
  "0 core" "1 vocabulary and theorems" "2 wire codecs" "3 bus" "4 beliefs, laws, world, recordings" "5 both ends of each wire"
  "6 assemblies" "7 lockstep, doctor" "8 programs")

# motionlab_library(NAME LAYER n DIRECTORY dir SOURCES … [LINKS …] [EXTERNAL …])
#   LINKS     targets of the house, each of a lower layer
#   EXTERNAL  other people's libraries
function(motionlab_library NAME)
  cmake_parse_arguments(ARG "" "LAYER;DIRECTORY" "SOURCES;LINKS;EXTERNAL" ${ARGN})
  if(NOT ARG_DIRECTORY)
    file(RELATIVE_PATH ARG_DIRECTORY ${PROJECT_SOURCE_DIR} ${CMAKE_CURRENT_SOURCE_DIR})
  endif()
  if(ARG_SOURCES)
    add_library(${NAME} STATIC ${ARG_SOURCES})
    target_link_libraries(${NAME} PUBLIC motionlab_flags)
    target_link_libraries(${NAME} PUBLIC ${ARG_LINKS} ${ARG_EXTERNAL})
  else()
    add_library(${NAME} INTERFACE)
    target_link_libraries(${NAME} INTERFACE motionlab_flags ${ARG_LINKS} ${ARG_EXTERNAL})
  endif()
  motionlab_register(${NAME} ${ARG_LAYER} ${ARG_DIRECTORY} "${ARG_SOURCES}" "${ARG_LINKS}")
endfunction()

# motionlab_program(NAME SOURCES … [LINKS …] [EXTERNAL …] [MAN n] [COMPONENT c]): an executable of layer 8, installed.
#   MAN        section of the manual page that is made from its --help
#   COMPONENT  the Debian package that it comes in: gateway or sim
function(motionlab_program NAME)
  cmake_parse_arguments(ARG "" "MAN;COMPONENT" "SOURCES;LINKS;EXTERNAL" ${ARGN})
  if(NOT ARG_COMPONENT)
    set(ARG_COMPONENT gateway)
  endif()
  file(RELATIVE_PATH DIRECTORY ${PROJECT_SOURCE_DIR} ${CMAKE_CURRENT_SOURCE_DIR})
  add_executable(${NAME} ${ARG_SOURCES})
  target_link_libraries(${NAME} PRIVATE motionlab_flags ${ARG_LINKS} ${ARG_EXTERNAL})
  install(TARGETS ${NAME} RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT ${ARG_COMPONENT})
  if(ARG_MAN AND NOT CMAKE_CROSSCOMPILING)  # the program is run
    set(PAGE ${NAME}.${ARG_MAN}.gz)
    motionlab_made(${NAME} man_${NAME} ${PAGE} ${CMAKE_INSTALL_MANDIR}/man${ARG_MAN} ${PAGE} COMPONENT ${ARG_COMPONENT}
      DEPENDS ${PROJECT_SOURCE_DIR}/.cmake/man_page.py
      COMMAND Python3::Interpreter ${PROJECT_SOURCE_DIR}/.cmake/man_page.py $<TARGET_FILE:${NAME}> ${NAME} ${ARG_MAN}
              ${PROJECT_VERSION} ${CMAKE_CURRENT_BINARY_DIR}/${PAGE})
  endif()
  motionlab_register(${NAME} 8 ${DIRECTORY} "${ARG_SOURCES}" "${ARG_LINKS}")
endfunction()

# motionlab_made(PROGRAM TARGET FILE FOLDER INSTALLED_NAME [COMPONENT c] [DEPENDS …] COMMAND …): a file of this build folder
# that a command makes with the help of a program of the house; installed, with the gateway's package if nothing is said.
function(motionlab_made PROGRAM TARGET FILE FOLDER INSTALLED_NAME)
  cmake_parse_arguments(ARG "" "COMPONENT" "DEPENDS;COMMAND" ${ARGN})
  if(NOT ARG_COMPONENT)
    set(ARG_COMPONENT gateway)
  endif()
  add_custom_command(OUTPUT ${CMAKE_CURRENT_BINARY_DIR}/${FILE} COMMAND ${ARG_COMMAND}
                     DEPENDS ${PROGRAM} ${ARG_DEPENDS} VERBATIM)
  add_custom_target(${TARGET} ALL DEPENDS ${CMAKE_CURRENT_BINARY_DIR}/${FILE})
  install(FILES ${CMAKE_CURRENT_BINARY_DIR}/${FILE} DESTINATION ${FOLDER} RENAME ${INSTALLED_NAME}
          COMPONENT ${ARG_COMPONENT})
endfunction()

function(motionlab_register NAME LAYER DIRECTORY SOURCES LINKS)
  foreach(DEPENDENCY IN LISTS LINKS)
    get_property(BELOW GLOBAL PROPERTY MOTIONLAB_LAYER_${DEPENDENCY})
    if("${BELOW}" STREQUAL "")
      message(FATAL_ERROR "${NAME} links ${DEPENDENCY}, which is no target of the house (yet). "
        "Other people's libraries go to EXTERNAL; a target of a higher layer cannot be linked.")
    endif()
    if(NOT BELOW LESS LAYER)
      list(GET MOTIONLAB_LAYER_NAMES ${LAYER} HERE)
      list(GET MOTIONLAB_LAYER_NAMES ${BELOW} THERE)
      message(FATAL_ERROR "${NAME} (layer ${HERE}) must not link ${DEPENDENCY} (layer ${THERE}): "
        "links go strictly downhill. Move the shared part to a lower layer, or pass it in from above.")
    endif()
  endforeach()
  set_property(GLOBAL PROPERTY MOTIONLAB_LAYER_${NAME} ${LAYER})
  set_property(GLOBAL PROPERTY MOTIONLAB_LINKS_${NAME} "${LINKS}")
  set_property(GLOBAL PROPERTY MOTIONLAB_DIRECTORY_${NAME} ${DIRECTORY})
  set_property(GLOBAL APPEND PROPERTY MOTIONLAB_TARGETS ${NAME})
endfunction()

# A quoted include is an edge too: every `#include "dir/file"` of a source or header must name a file of the
# target itself or of one that it links, directly or through others.
function(motionlab_check_includes)
  get_property(TARGETS GLOBAL PROPERTY MOTIONLAB_TARGETS)
  foreach(NAME IN LISTS TARGETS)
    get_property(DIRECTORY GLOBAL PROPERTY MOTIONLAB_DIRECTORY_${NAME})
    motionlab_closure(${NAME} SEEN)
    set(ALLOWED "")
    foreach(DEPENDENCY IN LISTS SEEN)
      get_property(DEPENDENCY_DIRECTORY GLOBAL PROPERTY MOTIONLAB_DIRECTORY_${DEPENDENCY})
      motionlab_file_pattern(${DEPENDENCY} PATTERN)
      list(APPEND ALLOWED "^${PATTERN}")
    endforeach()
    motionlab_file_pattern(${NAME} OWN)
    file(GLOB FILES RELATIVE ${PROJECT_SOURCE_DIR} ${PROJECT_SOURCE_DIR}/${DIRECTORY}/*.hpp
         ${PROJECT_SOURCE_DIR}/${DIRECTORY}/*.cpp)
    foreach(FILE IN LISTS FILES)
      if(NOT FILE MATCHES "^${OWN}")
        continue()
      endif()
      file(STRINGS ${PROJECT_SOURCE_DIR}/${FILE} INCLUDES REGEX "^#include \"")
      foreach(LINE IN LISTS INCLUDES)
        string(REGEX REPLACE "^#include \"([^\"]+)\".*" "\\1" INCLUDED "${LINE}")
        set(FOUND FALSE)
        foreach(PATTERN IN LISTS ALLOWED)
          if(INCLUDED MATCHES "${PATTERN}")
            set(FOUND TRUE)
          endif()
        endforeach()
        if(NOT FOUND)
          message(FATAL_ERROR "${FILE} includes \"${INCLUDED}\", but ${NAME} does not link the target it belongs "
            "to. An include is an edge: link it (downhill only), or pass what you need in from above.")
        endif()
      endforeach()
    endforeach()
  endforeach()
endfunction()

# The files that belong to a target: of a device folder, only the half with its own name.
function(motionlab_file_pattern NAME RESULT)
  get_property(DIRECTORY GLOBAL PROPERTY MOTIONLAB_DIRECTORY_${NAME})
  if(NAME MATCHES "^(wire|driver|device)_(.+)$")
    set(${RESULT} "${DIRECTORY}/${CMAKE_MATCH_2}_${CMAKE_MATCH_1}" PARENT_SCOPE)
  else()
    set(${RESULT} "${DIRECTORY}/[^/]+$" PARENT_SCOPE)
  endif()
endfunction()

function(motionlab_closure NAME RESULT)
  set(SEEN ${NAME})
  set(QUEUE ${NAME})
  while(QUEUE)
    list(POP_FRONT QUEUE NEXT)
    get_property(LINKS GLOBAL PROPERTY MOTIONLAB_LINKS_${NEXT})
    foreach(DEPENDENCY IN LISTS LINKS)
      if(NOT DEPENDENCY IN_LIST SEEN)
        list(APPEND SEEN ${DEPENDENCY})
        list(APPEND QUEUE ${DEPENDENCY})
      endif()
    endforeach()
  endwhile()
  set(${RESULT} ${SEEN} PARENT_SCOPE)
endfunction()
