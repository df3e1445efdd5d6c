# The licence, and who must be named for the tables that are compiled in; a wheel has them by pyproject.toml.
if(NOT SKBUILD)
    install(FILES data/README.md RENAME DATA.md DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT documents)
    install(FILES LICENSE DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT documents)
    install(DIRECTORY LICENSES DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT documents)
endif()
