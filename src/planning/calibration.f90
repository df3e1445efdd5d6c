!> A calibration: a case, which is simulated, and how it is estimated. One file has both, each in groups of its
!> own: the simulation reads the case, the estimators read their options.
module gracecg_planning_calibration
    use gracecg_base_error, only: error_t, add_context
    use gracecg_files_file, only: output_file_t, file_exists
    use gracecg_observations_observation_files, only: read_observations, OBSERVATION_FILES, SETUP_FILE
    use gracecg_observations_observation_set, only: observation_set_t
    use gracecg_simulation_case, only: case_t, case_from_text, case_text
    use gracecg_simulation_report_cases, only: published_name
    use gracecg_simulation_case_library, only: find_case, is_built_in
    use gracecg_estimation_options, only: estimation_options_t, read_options, options_from_text, options_text
    use gracecg_estimation_estimators, only: estimate_offset
    use gracecg_estimation_report_options, only: report_options
    use gracecg_estimation_solution, only: solution_t
    use gracecg_planning_observed_case, only: case_of_observations
    implicit none
    private
    public :: calibration_t, find_calibration, calibration_from_text, calibration_text, write_calibration

    !> A case and how it is estimated.
    type :: calibration_t
        type(case_t) :: case                        !! What is simulated
        type(estimation_options_t) :: options       !! How it is estimated
    end type calibration_t

contains

    !> The calibration of a name: a built-in case with the report's options, else the namelist file of that path, or the
    !> folder of an observation set. Fails when it is none, and as `read_case`, `read_options` and `case_of_observations` do.
    subroutine find_calibration(name_or_path, calibration, error)
        character(*), intent(in) :: name_or_path    !! 'front-1' ... 'back-3-printed', or a path
        type(calibration_t), intent(out) :: calibration
        type(error_t), allocatable, intent(out) :: error

        type(observation_set_t) :: observations
        character(:), allocatable :: setup

        setup = name_or_path//'/'//trim(OBSERVATION_FILES(SETUP_FILE))
        if (file_exists(setup)) then
            call read_observations(name_or_path, observations, error)
            if (.not. allocated(error)) call case_of_observations(observations, calibration%case, error)
            if (.not. allocated(error)) call read_options(setup, calibration%options, error, beside=.true.)
            if (.not. allocated(error)) call take_offset()
            call add_context(error, name_or_path)
            return
        end if
        call find_case(name_or_path, calibration%case, error)
        if (allocated(error)) return
        if (is_built_in(name_or_path)) then
            calibration%options = report_options(trim(published_name(calibration%case%name)))
        else
            call read_options(name_or_path, calibration%options, error, beside=.true.)
        end if

    contains

        !> The offset that `optimal` finds, since some errors grow with it; else 0. A run that is too long for one fit has none.
        subroutine take_offset()
            type(estimation_options_t) :: quick
            type(solution_t) :: solution
            type(error_t), allocatable :: failure

            quick = calibration%options
            quick%test_beliefs = .false.
            call estimate_offset('optimal', observations, quick, solution, failure)
            if (allocated(failure)) return
            if (solution%converged) calibration%case%satellite%offset = solution%offset
        end subroutine take_offset
    end subroutine find_calibration

    !> The calibration of the text of a case file; `name` stands for the file in messages.
    subroutine calibration_from_text(text, name, calibration, error)
        character(*), intent(in) :: text, name      !! Content; what stands for the file in messages
        type(calibration_t), intent(out) :: calibration
        type(error_t), allocatable, intent(out) :: error

        call case_from_text(text, name, calibration%case, error)
        if (.not. allocated(error)) &
            call options_from_text(text, name, calibration%options, error, beside=.true.)
    end subroutine calibration_from_text

    !> The text of a case file with both: what `find_calibration` reads. Fails when a number is not finite.
    subroutine calibration_text(calibration, text, error)
        type(calibration_t), intent(in) :: calibration
        character(:), allocatable, intent(out) :: text  !! Lines separated by line feeds
        type(error_t), allocatable, intent(out) :: error

        character(:), allocatable :: options

        call case_text(calibration%case, text, error)
        if (.not. allocated(error)) call options_text(calibration%options, options, error)
        if (.not. allocated(error)) text = text//new_line('a')//new_line('a')//options
    end subroutine calibration_text

    !> The same as a file that every command takes for a case. Fails as calibration_text, and when it cannot be written.
    subroutine write_calibration(path, calibration, error)
        character(*), intent(in) :: path                !! An existing file is replaced
        type(calibration_t), intent(in) :: calibration
        type(error_t), allocatable, intent(out) :: error

        type(output_file_t) :: file
        character(:), allocatable :: text

        call calibration_text(calibration, text, error)
        if (.not. allocated(error)) call file%open(path, error)
        if (allocated(error)) return
        call file%about('!')
        call file%line(text)
        call file%commit(error)
    end subroutine write_calibration
end module gracecg_planning_calibration
