find_package(LAPACK REQUIRED)
find_package(OpenMP REQUIRED COMPONENTS Fortran)

# What every target is compiled with: fpm's release profile, files without a preprocessor,
# products rounded before they are added (tools/flags.sh).
# The rest of the arguments: the targets whose modules it uses. CMake follows modules through linked libraries only; so all is
# compiled anew when a module file of theirs has changed, and not before they are compiled (TARGET-modules).
function(compile_as_here target folder)
    set_target_properties(${target} PROPERTIES POSITION_INDEPENDENT_CODE ON
        Fortran_MODULE_DIRECTORY ${folder} Fortran_PREPROCESS OFF)
    target_compile_options(${target} PRIVATE
        "$<$<AND:$<COMPILE_LANG_AND_ID:Fortran,GNU>,$<CONFIG:Release>>:-O3;-funroll-loops>"
        "$<$<COMPILE_LANG_AND_ID:Fortran,GNU,LLVMFlang>:-ffp-contract=off>"
        "$<$<COMPILE_LANG_AND_ID:Fortran,GNU>:-fimplicit-none>")
    file(MAKE_DIRECTORY ${modules} ${level1_modules} ${PROJECT_BINARY_DIR}/program)    # a compiler warns of those that are not there
    target_include_directories(${target} PRIVATE ${modules} ${level1_modules} ${PROJECT_BINARY_DIR}/program)
    target_link_libraries(${target} PRIVATE LAPACK::LAPACK OpenMP::OpenMP_Fortran ${CMAKE_DL_LIBS})
    get_target_property(type ${target} TYPE)
    if(NOT top AND type STREQUAL "STATIC_LIBRARY")  # a linker of C in the project around it needs Fortran's run-time library
        set(run_time ${CMAKE_Fortran_IMPLICIT_LINK_LIBRARIES})
        list(REMOVE_ITEM run_time ${CMAKE_C_IMPLICIT_LINK_LIBRARIES} ${CMAKE_CXX_IMPLICIT_LINK_LIBRARIES})
        set(in_c "$<BUILD_INTERFACE:$<$<LINK_LANGUAGE:C,CXX>:")
        target_link_directories(${target} INTERFACE "${in_c}${CMAKE_Fortran_IMPLICIT_LINK_DIRECTORIES}>>")
        target_link_libraries(${target} INTERFACE "${in_c}${run_time}>>")
    endif()
    set(sums ${PROJECT_BINARY_DIR}/modules-of-)
    add_custom_command(OUTPUT ${sums}${target} DEPENDS ${target} $<TARGET_OBJECTS:${target}> VERBATIM COMMAND ${CMAKE_COMMAND}
        -D FOLDER=${folder} -D SUMS=${sums}${target} -P ${CMAKE_CURRENT_FUNCTION_LIST_DIR}/modules.cmake)
    add_custom_target(${target}-modules DEPENDS ${sums}${target})
    get_target_property(files ${target} SOURCES)
    list(FILTER files INCLUDE REGEX "\\.f90$")
    foreach(used ${ARGN})
        add_dependencies(${target} ${used}-modules)
        set_property(SOURCE ${files} APPEND PROPERTY OBJECT_DEPENDS ${sums}${used})
    endforeach()
endfunction()
