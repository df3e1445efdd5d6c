!> gracecg bound: the least error with which a case's manoeuvre lets the CG offset be estimated.
module gracecg_cli_bound
    use gracecg_base_kinds, only: dp, i8
    use gracecg_base_constants, only: MILLIMETRE
    use gracecg_base_error, only: error_t
    use gracecg_base_progress, only: tell
    use gracecg_base_text, only: join, padded, integer_text
    use gracecg_planning_calibration, only: calibration_t
    use gracecg_planning_bound, only: case_bound_t, bound_of_case, SOURCES
    use gracecg_cli_calibration_argument, only: add_options_option, add_cases_option, take_calibrations, MOST_CASES
    use gracecg_simulation_operator_errors, only: KNOWLEDGE_SOURCES => SOURCES
    use gracecg_studies_consider_check, only: consider_check_t, check_consider
    use gracecg_studies_knowledge_errors, only: size_text, estimates_of_all
    use gracecg_cli_arguments, only: arguments_t, MOST_RUNS
    use gracecg_cli_console, only: console_t, number_fields
    implicit none
    private
    public :: declare_bound, run_bound

    character(*), parameter :: COLUMNS = &
        'case,sigma_x_mm,sigma_y_mm,sigma_z_mm,worst_sigma_mm,worst_x,worst_y,worst_z'
    character(4), parameter :: FORMATS(2) = ['text', 'csv ']

contains

    !> Says what the command takes.
    subroutine declare_bound(arguments)
        type(arguments_t), intent(inout) :: arguments

        call arguments%describe('bound', '[CASE ...]', 0, MOST_CASES, &
                                'The Cramer-Rao bound of the CG offset: the least standard deviation that any '// &
                                'unbiased estimate can have with the manoeuvre and the noise spectra of a case '// &
                                '(built-in name or namelist file), the drag a straight line in time; the worst '// &
                                'direction; and what is added by scale factors, rod gain, magnetometer bias, '// &
                                'inertia and unmodelled torque that are known only within the limits of the '// &
                                'group `a_priori` of the case file (consider covariance).', &
                                'gracecg bound front-1 back-1')
        call add_cases_option(arguments, 'all, the six built-in cases')
        call arguments%add_option('--format', 'FORMAT', 'text (default) or csv')
        call arguments%add_option('--check', 'RUNS', 'draw every error of knowledge alone so often, estimate with '// &
                                  '`optimal` from observations without noise, and compare')
        call arguments%add_option('--seed', 'S', 'of the draws (default 1)')
        call arguments%add_option('--threads', 'N', 'for the draws (default: the processors of the machine)')
        call add_options_option(arguments)
    end subroutine declare_bound

    !> Computes the limit of a case and prints it.
    subroutine run_bound(arguments, console, misuse, error)
        type(arguments_t), intent(in) :: arguments
        type(console_t), intent(inout) :: console
        type(error_t), allocatable, intent(out) :: misuse, error

        type(calibration_t), allocatable :: calibrations(:)
        type(case_bound_t) :: bound
        character(:), allocatable :: output_format
        integer(i8) :: seed        !! Of the random numbers
        integer :: i, runs, threads

        call arguments%get('--format', output_format, misuse, default='text', choices=FORMATS)
        call arguments%get('--check', runs, misuse, default=0, low=1, high=MOST_RUNS)
        call arguments%get('--seed', seed, misuse, default=1_i8)
        call arguments%get_threads(threads, misuse)
        if (.not. allocated(misuse)) call take_calibrations(arguments, 'all', console, calibrations, misuse, error, &
                                                            may_rest=.true.)
        if (allocated(misuse) .or. allocated(error)) return
        call console%expect(size(calibrations)*estimates_of_all(runs), 'estimates')
        do i = 1, size(calibrations)
            call tell(console, 'bound, '//trim(calibrations(i)%case%name))
            call bound_of_case(calibrations(i)%case, calibrations(i)%options, bound, error)
            if (allocated(error)) return
            if (output_format == 'csv') then
                if (i == 1) call console%line(COLUMNS)
                call console%line(trim(calibrations(i)%case%name)//','//join(padded(number_fields( &
                    [[bound%sigma, bound%principal_sigma(3)]/MILLIMETRE, bound%direction(:, 3)])), ','))
            else
                if (i > 1) call console%line('')
                call print_text(calibrations(i), bound, console)
                if (runs > 0) call print_checks(calibrations(i), seed, runs, threads, console, error)
                if (allocated(error)) return
            end if
        end do
    end subroutine run_bound

    subroutine print_text(calibration, bound, console)
        type(calibration_t), intent(in) :: calibration
        type(case_bound_t), intent(in) :: bound
        type(console_t), intent(inout) :: console

        character(len(SOURCES)), allocatable :: estimated(:)
        character(120) :: line
        integer :: i

        call console%line(trim(calibration%case%name)//': least standard deviation of the CG offset, mm')
        write (line, '(a, 3(a12))') '                           ', 'x', 'y', 'z'
        call console%line(trim(line))
        write (line, '(a27, 3f12.5)') 'noise (Cramer-Rao bound)   ', bound%sigma/MILLIMETRE
        call console%line(trim(line))
        associate (asked => calibration%options%optimal)
            estimated = pack(SOURCES(:3), [asked%estimate_scale_factors, asked%estimate_rod_gain, &
                                           asked%estimate_magnetometer_bias])
        end associate
        if (size(estimated) > 0) &
            call console%line('  with the a-priori sigmas of '//join(estimated, ', ')//', which are estimated, too')
        do i = 1, size(SOURCES)
            if (.not. any(bound%by_source(:, i) > 0)) cycle
            write (line, '(a9, a18, 3f12.5)') '  adds by', ' '//SOURCES(i), bound%by_source(:, i)/MILLIMETRE
            call console%line(trim(line))
        end do
        do i = 1, size(KNOWLEDGE_SOURCES)
            if (.not. any(bound%by_knowledge(:, i) > 0)) cycle
            write (line, '(a27, 3f12.5)') '  '//KNOWLEDGE_SOURCES(i)%name//'     ', &
                bound%by_knowledge(:, i)/MILLIMETRE
            call console%line(trim(line))
        end do
        write (line, '(a27, 3f12.5)') 'all (consider covariance)  ', bound%consider_sigma/MILLIMETRE
        call console%line(trim(line))
        call console%line('error ellipsoid of the bound')
        do i = 3, 1, -1
            write (line, '(a27, f12.5, a, 3f9.4, a)') merge('  worst direction          ', &
                                                            '                           ', i == 3), &
                bound%principal_sigma(i)/MILLIMETRE, '   along (', bound%direction(:, i), ')'
            call console%line(trim(line))
        end do
    end subroutine print_text

    !> The consider covariance of every source, and what its draws give. Estimated sources add nothing.
    subroutine print_checks(calibration, seed, runs, threads, console, error)
        type(calibration_t), intent(in) :: calibration
        integer(i8), intent(in) :: seed        !! Of the random numbers
        integer, intent(in) :: runs, threads
        type(console_t), intent(inout) :: console
        type(error_t), allocatable, intent(out) :: error

        real(dp), parameter :: NOTHING = 1e-4_dp        ! of the noise: estimates are not iterated farther
        type(consider_check_t) :: check
        character(160) :: line
        character(8) :: deviation(3)
        integer :: i, axis

        call console%line('each source drawn in '//integer_text(runs)//' runs: considered sigma, mm, and '// &
                          'drawn minus considered, % (-: less than 1e-4 of the noise)')
        do i = 1, size(KNOWLEDGE_SOURCES)
            call tell(console, trim(calibration%case%name)//', '//trim(KNOWLEDGE_SOURCES(i)%name))
            call check_consider(calibration%case, calibration%options, i, seed, runs, threads, check, error, console)
            if (allocated(error)) return
            deviation = '       -'
            do axis = 1, 3
                if (min(check%rms(axis), check%considered(axis)) > NOTHING*check%noise(axis)) &
                    write (deviation(axis), '(f8.1)') 100*(check%rms(axis)/check%considered(axis) - 1)
            end do
            write (line, '(t3, 3(f11.6, a8), 2x, a)') (check%considered(axis)/MILLIMETRE, deviation(axis), &
                axis=1, 3), trim(size_text(check%knowledge_study_t))
            call console%line(trim(line))
        end do
    end subroutine print_checks
end module gracecg_cli_bound
