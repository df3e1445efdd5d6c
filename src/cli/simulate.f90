!> gracecg simulate: the true arc of a case and one noisy observation set.
module gracecg_cli_simulate
    use gracecg_base_kinds, only: dp, i8
    use gracecg_base_error, only: error_t
    use gracecg_base_version, only: VERSION
    use gracecg_base_text, only: string_t, integer_text
    use gracecg_files_file, only: make_directory, remove_file
    use gracecg_spacecraft_moment_series, only: has_moments
    use gracecg_spacecraft_torque_rods, only: moves_rods
    use gracecg_observations_observation_set, only: observation_set_t
    use gracecg_observations_observation_files, only: write_observations, OBSERVATION_FILES, SETUP_FILE
    use gracecg_estimation_options, only: estimation_options_t, write_options
    use gracecg_simulation_simulator, only: simulator_t, new_simulator, observe, drawn_wave, measure_rods
    use gracecg_simulation_instrument_limits, only: full_scale_warnings
    use gracecg_simulation_truth_file, only: write_truth
    use gracecg_planning_calibration, only: calibration_t
    use gracecg_cli_calibration_argument, only: take_calibration, warn_of_instruments
    use gracecg_cli_arguments, only: arguments_t, refuse_if
    use gracecg_cli_console, only: console_t, quoted_word
    use gracecg_cli_simulate_level1, only: simulate_level1
    implicit none
    private
    public :: declare_simulate, run_simulate

    character(12), parameter :: FORMATS(2) = [character(12) :: 'observations', 'level1']
    character(*), parameter :: TRUTH_FILE = 'truth.csv', OPTIONS_FILE = 'options.nml'

contains

    !> Arguments and help of `gracecg simulate`.
    subroutine declare_simulate(arguments)
        type(arguments_t), intent(inout) :: arguments

        call arguments%describe('simulate', 'CASE', 1, 1, &
                                'Propagates the true orbit and attitude of a case and draws '// &
                                'one noisy observation set. CASE is a built-in case (gracecg '// &
                                'cases) or a namelist file. Seed and run alone decide the '// &
                                'random numbers.', &
                                'gracecg simulate front-1 --out run1 --seed 1 --run 1')
        call arguments%add_option('--out', 'DIR', 'folder for '//TRUTH_FILE// &
                                  ' and the observation set; made if it is not there', &
                                  required=.true.)
        call arguments%add_option('--seed', 'S', 'of the random numbers (default 1)')
        call arguments%add_option('--run', 'K', &
                                  'number of the run: other random numbers of the same seed '// &
                                  '(default 1)')
        call arguments%add_option('--rods', 'S', 'also writes rods.csv, the moments that the torque rods truly '// &
                                  'had, every S seconds: estimate takes them in place of those commanded')
        call arguments%add_option('--format', 'FORMAT', 'observations (default), or level1: the files of GRACE or GRACE-FO '// &
                                  'of hours with several sub-manoeuvres, for level1 estimate', choices=FORMATS)
        call arguments%add_option('--level1', 'FILE', 'with --format level1: groups level1_simulation and '// &
                                  'level1_span (default: those of the case file)')
        call arguments%add_option('--binary', '', 'with --format level1: the binary records of GRACE in place of text')
    end subroutine declare_simulate

    !> The work of `gracecg simulate`.
    subroutine run_simulate(arguments, console, misuse, error)
        type(arguments_t), intent(in) :: arguments
        type(console_t), intent(inout) :: console
        type(error_t), allocatable, intent(out) :: misuse, error

        type(calibration_t) :: calibration
        type(simulator_t) :: simulator
        type(observation_set_t) :: observations
        type(string_t), allocatable :: warnings(:)
        character(:), allocatable :: folder, form, level1_file
        integer(i8) :: seed        !! Of the random numbers
        real(dp) :: rods_interval
        integer :: run, i

        call arguments%get('--out', folder, misuse)
        call arguments%get('--seed', seed, misuse, default=1_i8)
        call arguments%get('--run', run, misuse, default=1, low=0)
        call arguments%get('--rods', rods_interval, misuse, default=0.0_dp, low=1e-3_dp, high=10.0_dp)
        call arguments%get('--format', form, misuse, default=trim(FORMATS(1)), choices=FORMATS)
        call arguments%get('--level1', level1_file, misuse, default='')
        if (allocated(misuse)) return
        if (form == 'level1') then
            call refuse_if(rods_interval > 0, '--rods does not go with --format level1, whose currents are in MAG1B', misuse)
        else
            call refuse_if(level1_file /= '' .or. arguments%has('--binary'), '--level1 and --binary need --format level1', misuse)
        end if
        if (allocated(misuse)) return

        call take_calibration(arguments, arguments%positional(1), console, calibration, error)
        if (form == 'level1') then
            if (level1_file == '') level1_file = arguments%positional(1)
            if (.not. allocated(error)) &
                call simulate_level1(calibration%case, level1_file, arguments%has('--level1'), folder, seed, run, &
                                     arguments%has('--binary'), console, error)
            return
        end if
        if (.not. allocated(error)) call make_directory(folder, error)
        if (.not. allocated(error)) call new_simulator(calibration%case, simulator, error)
        if (.not. allocated(error)) call observe(simulator, seed, run, observations, error)
        if (.not. allocated(error) .and. rods_interval > 0) &
            call measure_rods(simulator, rods_interval, observations, error)
        if (.not. allocated(error)) &
            call write_run(folder, simulator, seed, run, observations, calibration%options, error)
        if (allocated(error)) return
        call warn_of_instruments(calibration%case, console)
        call full_scale_warnings(calibration%case%satellite, observations, warnings)
        do i = 1, size(warnings)
            call console%warn(warnings(i)%text)
        end do
        call report(folder, observations, console)
    end subroutine run_simulate

    !> Writes the truth and the observation set; after a failure none of them.
    subroutine write_run(folder, simulator, seed, run, observations, options, error)
        character(*), intent(in) :: folder
        type(simulator_t), intent(in) :: simulator
        integer(i8), intent(in) :: seed        !! Of the random numbers
        integer, intent(in) :: run
        type(observation_set_t), intent(in) :: observations
        type(estimation_options_t), intent(in) :: options
        type(error_t), allocatable, intent(out) :: error

        character(100) :: comments(2)

        comments(1) = 'gracecg '//VERSION//' simulate'
        comments(2) = 'case '//trim(simulator%case%name)//', seed '//integer_text(seed)// &
            ', run '//integer_text(run)
        call write_truth(folder//'/'//TRUTH_FILE, simulator, &
                         drawn_wave(simulator, seed, run), comments, error)
        if (allocated(error)) return
        call write_observations(folder, observations, comments, error)
        if (.not. allocated(error)) call write_options(folder//'/'//OPTIONS_FILE, options, comments, error)
        if (allocated(error)) call remove_file(folder//'/'//TRUTH_FILE)
    end subroutine write_run

    !> What was written, and what to do next.
    subroutine report(folder, observations, console)
        character(*), intent(in) :: folder
        type(observation_set_t), intent(in) :: observations
        type(console_t), intent(inout) :: console

        integer :: samples(4), i

        samples = [size(observations%accelerometer_time), size(observations%star_camera_time), &
                   size(observations%magnetometer_time), size(observations%orbit_time)]
        call console%line('written to '//folder//':')
        call console%line('  '//TRUTH_FILE//'          the true arc')
        do i = 1, size(samples)
            call console%line('  '//OBSERVATION_FILES(i)//'  '//integer_text(samples(i))// &
                              trim(merge(' positions', ' samples  ', i == 4)))
        end do
        associate (measured => observations%knowledge%rods%measured)
            if (has_moments(measured)) call console%line('  '//OBSERVATION_FILES(5)//'  '// &
                                                         integer_text(size(measured%time))//' samples')
        end associate
        call console%line('  '//OBSERVATION_FILES(SETUP_FILE)//'  what the operator knows')
        call console%line('  '//OPTIONS_FILE//'        how the case is estimated')
        if (moves_rods(observations%knowledge%rods, observations%knowledge%duration)) then
            call console%line('next: gracecg estimate '//quoted_word(folder)//' --algorithm assest-fde --options '// &
                              quoted_word(folder//'/'//OPTIONS_FILE))
        else
            call console%warn('all torque rods are off: from these observations no CG offset can '// &
                                 'be estimated')
        end if
    end subroutine report
end module gracecg_cli_simulate
