!> gracecg level1 simulate: a folder of Level-1 files of hours with several sub-manoeuvres.
module gracecg_level1_command_simulate
    use gracecg_base_text, only: pick_text
    use gracecg_files_csv, only: SIDE_ENDING
    use gracecg_files_file, only: directory_exists, file_exists, make_directory, text_file_t, read_text_file
    use gracecg_files_path, only: files_in_folder
    use gracecg_files_run_record, only: note_file, UPDATED
    use gracecg_observations_observation_files, only: OBSERVATION_FILES
    use gracecg_level1_header, only: name_of, product_of_file_name
    use gracecg_level1_time, only: gps_day
    use gracecg_level1_simulated_files, only: write_level1_folder
    use gracecg_level1_simulated_folder, only: SETUP_NAME, TRUTH_TABLE, TRUTH_NAMELIST
    use gracecg_level1_simulation_settings, only: level1_settings_t, read_level1_settings
    use gracecg_level1_simulated_truth, only: level1_truth_t, new_level1_truth
    use gracecg_cli_calibration_argument, only: take_calibration
    use gracecg_cli_console, only: quoted_word
    use gracecg_cli_work
    implicit none
    private
    public :: declare_level1_simulate, run_level1_simulate

contains

    !> Arguments and help of `gracecg level1 simulate`.
    subroutine declare_level1_simulate(arguments)
        type(arguments_t), intent(inout) :: arguments

        call arguments%describe('level1 simulate', 'CASE', 1, 1, &
                                'Simulates a folder of Level-1 files of GRACE or GRACE-FO for level1 estimate: hours with '// &
                                'several sub-manoeuvres on the orbit of a case. CASE is a built-in case (gracecg cases) or a '// &
                                'namelist file, whose groups level1_simulation and level1_span say how.', &
                                'gracecg level1 simulate front-1 --out day1')
        call arguments%add_option('--out', 'DIR', 'folder for the files; made if it is not there', required=.true.)
        call add_study_options(arguments, '--seed --run')
        call arguments%add_option('--level1', 'FILE', 'groups level1_simulation and level1_span (default: those of the case '// &
                                  'file)')
        call arguments%add_option('--binary', '', 'the binary records of GRACE in place of text')
    end subroutine declare_level1_simulate

    !> The work of `gracecg level1 simulate`.
    subroutine run_level1_simulate(arguments, console, misuse, error)
        type(arguments_t), intent(in) :: arguments
        type(console_t), intent(inout) :: console
        type(error_t), allocatable, intent(out) :: misuse, error

        type(calibration_t) :: calibration
        type(level1_settings_t) :: settings
        type(level1_truth_t) :: truth
        type(string_t), allocatable :: written(:)
        character(:), allocatable :: folder, settings_file, before, now
        integer(i8) :: seed
        integer :: run, i

        call arguments%get('--out', folder, misuse)
        call arguments%get('--seed', seed, misuse)
        call arguments%get('--run', run, misuse, low=0)
        call arguments%get('--level1', settings_file, misuse)
        if (settings_file == '') settings_file = arguments%positional(1)
        if (allocated(misuse)) return
        call take_calibration(arguments, arguments%positional(1), calibration, error, may_rest=.true.)
        if (allocated(error)) return
        if (arguments%has('--level1') .or. file_exists(settings_file)) then
            call read_level1_settings(settings_file, settings, error)
            if (allocated(error)) return
        end if
        call new_level1_truth(calibration%case, settings, seed, run, truth, error)
        if (allocated(truth%remark)) call console%warn(truth%remark)
        if (.not. allocated(error)) call warn_of_moments(truth, console)
        if (.not. allocated(error)) call refuse_other_files(folder, truth, error)
        if (.not. allocated(error)) call find_scenario(folder, before)
        if (.not. allocated(error)) call make_directory(folder, error)
        if (.not. allocated(error)) call write_level1_folder(truth, folder, arguments%has('--binary'), written, error)
        if (allocated(error)) return
        call find_scenario(folder, now)
        if (before /= '' .and. before /= now) &
            call console%warn(folder//' held a simulation of another scenario, which this one has replaced')
        call console%line('written to '//folder//': satellite '//truth%satellite//', '//trim(utc_text(truth%case%epoch))// &
                          ', '//integer_text(truth%duration)//' s, '//integer_text(size(truth%dynamics%spans))// &
                          ' sub-manoeuvres of the groups level1_span; the rods of the case are not flown')
        do i = 1, size(written)
            call console%line('  '//written(i)%text)
        end do
        call console%line('next: gracecg level1 estimate '//quoted_word(folder)//' --setup '// &
                          quoted_word(folder//'/'//SETUP_NAME)//pick_text(size(truth%dynamics%spans) > 0, '', ' --every 5640'))
    end subroutine run_level1_simulate

    !> What a folder holds the simulation of: the case, and all groups of the simulation; empty: of nothing.
    subroutine find_scenario(folder, scenario)
        character(*), intent(in) :: folder
        character(:), allocatable, intent(out) :: scenario

        character(*), parameter :: CASE_LINE = '"case '
        type(text_file_t) :: about, truth
        type(error_t), allocatable :: unreadable
        integer :: i

        scenario = ''
        if (.not. (file_exists(folder//'/'//TRUTH_TABLE//SIDE_ENDING) .and. file_exists(folder//'/'//TRUTH_NAMELIST))) return
        call note_file(folder//'/'//TRUTH_TABLE//SIDE_ENDING, UPDATED)      ! looked at, and then replaced
        call note_file(folder//'/'//TRUTH_NAMELIST, UPDATED)
        call read_text_file(folder//'/'//TRUTH_TABLE//SIDE_ENDING, about, unreadable)
        if (.not. allocated(unreadable)) call read_text_file(folder//'/'//TRUTH_NAMELIST, truth, unreadable)
        if (allocated(unreadable)) return
        do i = 1, about%line_count()
            if (index(about%line(i), CASE_LINE) > 0) scenario = trim(about%line(i))
        end do
        scenario = scenario//truth%text(max(1, index(truth%text, '&level1_simulation')):)
    end subroutine find_scenario

    !> Says that the currents of the spans make more than a rod of the case bears.
    subroutine warn_of_moments(truth, console)
        type(level1_truth_t), intent(in) :: truth
        type(console_t), intent(inout) :: console

        real(dp) :: greatest
        integer :: i

        associate (borne => truth%case%satellite%rods%largest_moment, spans => truth%dynamics%spans)
            greatest = maxval([0.0_dp, (abs(spans(i)%amplitude*truth%settings%rod_gain), i=1, size(spans))])
            if (greatest > borne) call console%warn('the spans drive rods with '//rounded_text(greatest, 3)//' A m^2 '// &
                '(amplitude_ma times rod_gain), more than the '//rounded_text(borne, 3)//' A m^2 that those of the case bear')
        end associate
    end subroutine warn_of_moments

    !> Fails when the folder has Level-1 files that are none of the simulation: estimates would join both.
    subroutine refuse_other_files(folder, truth, error)
        character(*), intent(in) :: folder
        type(level1_truth_t), intent(in) :: truth
        type(error_t), allocatable, intent(out) :: error

        type(string_t), allocatable :: files(:)
        character(256) :: name
        integer :: i

        if (.not. directory_exists(folder)) return
        if (file_exists(folder//'/'//trim(OBSERVATION_FILES(1)))) then
            call fail(error, folder//' holds an observation set, whose setup.nml would be lost: take another folder')
            return
        end if
        call files_in_folder(folder, files, error)
        if (allocated(error)) return
        do i = 1, size(files)
            if (product_of_file_name(files(i)%text) == '') cycle
            name = name_of(files(i)%text)       ! such as ACC1A_2020-02-01_C_04.txt
            if (name(7:18) == gps_day(truth%epoch)//'_'//truth%satellite .and. file_exists(folder//'/truth.csv')) cycle
            call fail(error, folder//' holds '//trim(name)//', which is of no simulation of '//gps_day(truth%epoch)// &
                      ': estimates would join both; take another folder')
            return
        end do
    end subroutine refuse_other_files
end module gracecg_level1_command_simulate
