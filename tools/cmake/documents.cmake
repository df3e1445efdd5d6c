# The licence, and who must be named for the tables that are compiled in; a wheel has them by pyproject.toml.
if(NOT SKBUILD)
    install(FILES data/README.md RENAME DATA.md DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT documents)
    install(FILES LICENSE DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT documents)
    install(DIRECTORY LICENSES DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT documents)
endif()

# A wheel may bring an OpenMP library for systems that have none (python/gracecg/_library.py): the compiler's, or a file.
if(SKBUILD AND GRACECG_OWN_LIBGOMP)
    set(libgomp ${GRACECG_OWN_LIBGOMP})
    if(NOT IS_ABSOLUTE "${libgomp}")
        execute_process(COMMAND ${CMAKE_Fortran_COMPILER} -print-file-name=libgomp.so.1 OUTPUT_VARIABLE libgomp
            OUTPUT_STRIP_TRAILING_WHITESPACE COMMAND_ERROR_IS_FATAL ANY)
    endif()
    file(REAL_PATH ${libgomp} libgomp)
    install(FILES ${libgomp} RENAME libgomp.so.1 DESTINATION libgomp)
endif()
