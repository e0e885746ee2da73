# What is installed besides the programs, and the two Debian packages: motionlab-gateway and motionlab-sim (cpack -G DEB).
# A component is a package. `cmake --install` installs what lives under the prefix; what a package puts into /etc comes with
# the package alone.
set(MOTIONLAB_DEPLOY ${PROJECT_SOURCE_DIR}/deploy)
set(MOTIONLAB_UNITS lib/systemd/system)

install(FILES ${MOTIONLAB_DEPLOY}/systemd/motionlab-gateway.service ${MOTIONLAB_DEPLOY}/systemd/motionlab-console.service
              ${MOTIONLAB_DEPLOY}/systemd/motionlab-recorder.service ${MOTIONLAB_DEPLOY}/systemd/motionlab.target
        DESTINATION ${MOTIONLAB_UNITS} COMPONENT gateway)
install(FILES ${MOTIONLAB_DEPLOY}/config/lab.toml DESTINATION /etc/motionlab COMPONENT gateway EXCLUDE_FROM_ALL)
install(DIRECTORY ${MOTIONLAB_DEPLOY}/docs/ DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/motionlab-gateway COMPONENT gateway
        FILES_MATCHING PATTERN *.md)
install(PROGRAMS ${MOTIONLAB_DEPLOY}/security/identities.sh DESTINATION ${CMAKE_INSTALL_DATADIR}/motionlab/security
        COMPONENT gateway)
install(DIRECTORY ${MOTIONLAB_DEPLOY}/plc DESTINATION ${CMAKE_INSTALL_DATADIR}/motionlab COMPONENT gateway)

install(FILES ${MOTIONLAB_DEPLOY}/systemd/motionlab-sim.service DESTINATION ${MOTIONLAB_UNITS} COMPONENT sim)
install(FILES ${MOTIONLAB_DEPLOY}/config/world.toml DESTINATION /etc/motionlab COMPONENT sim EXCLUDE_FROM_ALL)
install(FILES ${MOTIONLAB_DEPLOY}/config/loopback.toml ${MOTIONLAB_DEPLOY}/config/shared-vm.toml
        DESTINATION ${CMAKE_INSTALL_DATADIR}/motionlab COMPONENT sim)

# Debian wants its changelog compressed, without a time stamp, and a copyright file in every package.
set(MOTIONLAB_CHANGELOG ${PROJECT_BINARY_DIR}/changelog.gz)
execute_process(COMMAND gzip -9nc ${MOTIONLAB_DEPLOY}/debian/changelog OUTPUT_FILE ${MOTIONLAB_CHANGELOG}
                COMMAND_ERROR_IS_FATAL ANY)
set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${MOTIONLAB_DEPLOY}/debian/changelog)
foreach(COMPONENT gateway sim)
  install(FILES ${MOTIONLAB_CHANGELOG} ${MOTIONLAB_DEPLOY}/debian/copyright
          DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/motionlab-${COMPONENT} COMPONENT ${COMPONENT})
  install(FILES ${MOTIONLAB_DEPLOY}/debian/motionlab-${COMPONENT}.lintian DESTINATION share/lintian/overrides
          RENAME motionlab-${COMPONENT} COMPONENT ${COMPONENT})
endforeach()

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME motionlab)
set(CPACK_PACKAGE_CONTACT "motionlab-gateway maintainers <maintainers@motionlab-gateway.org>")
set(CPACK_PACKAGE_DIRECTORY ${PROJECT_BINARY_DIR}/packages)
set(CPACK_COMPONENTS_ALL gateway sim)
set(CPACK_STRIP_FILES ON)
# The programs look in /etc/motionlab, wherever they were built for.
set(CPACK_SET_DESTDIR ON)
set(CPACK_INSTALL_PREFIX /usr)
set(CPACK_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS
    OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE WORLD_READ WORLD_EXECUTE)

set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)
set(CPACK_DEBIAN_COMPRESSION_TYPE xz)

set(CPACK_DEBIAN_GATEWAY_PACKAGE_NAME motionlab-gateway)
set(CPACK_DEBIAN_GATEWAY_PACKAGE_SECTION science)
set(CPACK_DEBIAN_GATEWAY_PACKAGE_SUGGESTS "motionlab-sim, nftables, openssl, fastdds-tools")
set(CPACK_COMPONENT_GATEWAY_DESCRIPTION
"gateway between a ship-motion laboratory's devices and a controller
Speaks the wire protocols of motion reference units, a camera system, a crane
arm and a winch, brings every sample onto DDS with its age, and keeps the load
still while the ship rolls. Nothing moves before a person asks for it.
.
The service is not started by being installed: read
/usr/share/doc/motionlab-gateway/install.md first.")
set(CPACK_DEBIAN_SIM_PACKAGE_NAME motionlab-sim)
set(CPACK_DEBIAN_SIM_PACKAGE_SECTION science)
set(CPACK_DEBIAN_SIM_PACKAGE_SUGGESTS motionlab-gateway)
set(CPACK_COMPONENT_SIM_DESCRIPTION
"simulated ship-motion laboratory for motionlab-gateway
The devices' ends of the same wires: motion reference units, cameras, crane
arm and winch above a simulated sea, in real time on real sockets, and a study
program that runs gateway and laboratory together without a clock.")

set(SCRIPTS ${MOTIONLAB_DEPLOY}/debian)
set(CPACK_DEBIAN_GATEWAY_PACKAGE_CONTROL_EXTRA ${SCRIPTS}/gateway/conffiles ${SCRIPTS}/gateway/postinst
    ${SCRIPTS}/gateway/prerm ${SCRIPTS}/gateway/postrm)
set(CPACK_DEBIAN_SIM_PACKAGE_CONTROL_EXTRA ${SCRIPTS}/sim/conffiles ${SCRIPTS}/sim/postinst
    ${SCRIPTS}/sim/prerm ${SCRIPTS}/sim/postrm)
include(CPack)
