!> gracecg bound: the least error with which a case's manoeuvre lets the CG offset be estimated.
module gracecg_cli_bound
    use gracecg_base_kinds, only: dp, i8
    use gracecg_base_constants, only: MILLIMETRE
    use gracecg_base_error, only: error_t
    use gracecg_base_progress, only: tell
    use gracecg_base_text, only: join, integer_text, rounded_text
    use gracecg_planning_calibration, only: calibration_t
    use gracecg_base_lapack, only: symmetric_eigen
    use gracecg_estimation_belief, only: BELIEFS
    use gracecg_estimation_belief_report, only: belief_report_t, FAMILY_LEVEL, POWER
    use gracecg_estimation_joint_estimate, only: joint_options_t, joint_solution_t, estimate_jointly
    use gracecg_estimation_run_information, only: run_information_t
    use gracecg_planning_leakage, only: leakage_pair_t, leakage_of_case
    use gracecg_planning_bound, only: case_bound_t, bound_of_case, reliability_of_case, information_of_case, SOURCES
    use gracecg_cli_calibration_argument, only: add_options_option, add_cases_option, take_calibrations, MOST_CASES
    use gracecg_simulation_operator_errors, only: KNOWLEDGE_SOURCES => SOURCES
    use gracecg_studies_consider_check, only: consider_check_t, check_consider
    use gracecg_studies_knowledge_errors, only: size_text, estimates_of_all
    use gracecg_cli_arguments, only: arguments_t, MOST_RUNS
    use gracecg_cli_console, only: console_t, console_width, wrapped
    use gracecg_cli_leakage, only: show_leakage, put_leakage
    use gracecg_cli_results, only: results_t, add_format_option, take_format
    use gracecg_files_data_table, only: data_table_t
    implicit none
    private
    public :: declare_bound, run_bound

    character(*), parameter :: COLUMNS = &
        'case,sigma_x_mm,sigma_y_mm,sigma_z_mm,worst_sigma_mm,worst_x,worst_y,worst_z,'// &
        'consider_x_mm,consider_y_mm,consider_z_mm'

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
                                'gracecg bound front-1 back-1'//new_line('a')//'gracecg bound front-2 front-3 --joint')
        call add_cases_option(arguments, 'all, the six built-in cases')
        call add_format_option(arguments)
        call arguments%add_option('--joint', '', 'also of all cases together, as calibrations of one offset: what one joint '// &
                                  'estimate could reach')
        call arguments%add_option('--leakage', '', 'also with the leakage of the rods into the accelerometer estimated, of '// &
                                  'one flight and of a second one half a revolution away')
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
        type(leakage_pair_t) :: pair
        type(results_t) :: results
        type(data_table_t) :: table
        integer(i8) :: seed        !! Of the random numbers
        integer :: i, runs, threads

        call take_format(arguments, console, misuse)
        call arguments%get('--check', runs, misuse, default=0, low=1, high=MOST_RUNS)
        call arguments%get('--seed', seed, misuse, default=1_i8)
        call arguments%get_threads(threads, misuse)
        if (.not. allocated(misuse)) call take_calibrations(arguments, 'all', console, calibrations, misuse, error, &
                                                            may_rest=.true.)
        if (allocated(misuse) .or. allocated(error)) return
        call table%columns_of(COLUMNS)
        call results%open('bound')
        if (runs > 0) call results%member('seed', seed)
        call results%begin_array('cases')
        call console%expect(size(calibrations)*estimates_of_all(runs), 'estimates')
        do i = 1, size(calibrations)
            associate (calibration => calibrations(i))
                call tell(console, 'bound, '//trim(calibration%case%name))
                call bound_of_case(calibration%case, calibration%options, bound, error)
                if (allocated(error)) return
                call table%add(calibration%case%name)
                call table%add([[bound%sigma, bound%principal_sigma(3)]/MILLIMETRE, bound%direction(:, 3)])
                call table%add([bound%consider_sigma]/MILLIMETRE)
                if (i > 1) call console%line('')
                call print_text(calibration, bound, console)
                call put_details(calibration, bound, results)
                if (arguments%has('--leakage')) then
                    call leakage_of_case(calibration%case, pair, error)
                    if (allocated(error)) return
                    call show_leakage(pair, calibration%case, console)
                    call put_leakage(pair, results)
                end if
                call show_reliability(calibration, console, results, error)
                if (allocated(error)) return
                if (runs > 0) call print_checks(calibration, seed, runs, threads, console, results, error)
                if (allocated(error)) return
                call results%end()
            end associate
        end do
        call results%end()
        if (arguments%has('--joint')) call add_joint_bound(calibrations, table, console, results, error)
        if (.not. allocated(error)) call results%publish(table, console, error)
    end subroutine run_bound

    !> The bound of all cases together: by noise alone, and with what is estimated beside the offset, one value for all.
    subroutine add_joint_bound(calibrations, table, console, results, error)
        type(calibration_t), intent(in) :: calibrations(:)
        type(data_table_t), intent(inout) :: table
        type(console_t), intent(inout) :: console
        type(results_t), intent(inout) :: results
        type(error_t), allocatable, intent(out) :: error

        type(run_information_t) :: information(size(calibrations))
        type(joint_solution_t) :: all_estimated, noise
        type(joint_options_t) :: shared
        character(120) :: line
        real(dp) :: values(3), directions(3, 3)
        integer :: i

        do i = 1, size(calibrations)
            call information_of_case(calibrations(i)%case, calibrations(i)%options, information(i), error)
            if (allocated(error)) return
        end do
        call estimate_jointly(information, shared, all_estimated, error)
        if (allocated(error)) return
        do i = 1, size(information)
            information(i)%estimated = .false.
        end do
        call estimate_jointly(information, shared, noise, error)
        if (.not. allocated(error)) call symmetric_eigen(all_estimated%covariance, values, directions, error)
        if (allocated(error)) return
        call console%line('')
        call console%line('all of them together, mm')
        write (line, '(a27, 3f12.5)') 'noise alone                ', (sqrt(noise%covariance(i, i))/MILLIMETRE, i=1, 3)
        call console%line(trim(line))
        if (any(all_estimated%parameter_sigma > 0)) then
            write (line, '(a27, 3f12.5)') 'with what is estimated, too', &
                (sqrt(all_estimated%covariance(i, i))/MILLIMETRE, i=1, 3)
            call console%line(trim(line))
        end if
        call results%begin('joint')
        call results%member('noise_alone_mm', [(sqrt(noise%covariance(i, i))/MILLIMETRE, i=1, 3)])
        call results%member('sigma_mm', [(sqrt(all_estimated%covariance(i, i))/MILLIMETRE, i=1, 3)])
        call results%end()
        call table%add('joint')
        call table%add([[(sqrt(all_estimated%covariance(i, i)), i=1, 3), sqrt(values(3))]/MILLIMETRE, directions(:, 3)])
        do i = 1, 3
            call table%add_nothing()
        end do
    end subroutine add_joint_bound

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

    !> Of each thing that an operator believes, the smallest wrong value that the tests of `optimal` would find, and
    !> what it would do to the offset.
    subroutine show_reliability(calibration, console, results, error)
        type(calibration_t), intent(in) :: calibration
        type(console_t), intent(inout) :: console
        type(results_t), intent(inout) :: results
        type(error_t), allocatable, intent(out) :: error

        type(belief_report_t) :: report
        character(120) :: line
        character(10) :: detectable
        real(dp) :: smallest
        integer :: i, shown

        shown = 0
        call reliability_of_case(calibration%case, calibration%options, report, error)
        if (allocated(error)) return
        call console%paragraph('What a wrong belief could do unseen: the smallest value found with probability '// &
                          rounded_text(POWER, 2)//' (level '//rounded_text(FAMILY_LEVEL, 1)//' for all tests), or the '// &
                          'largest conceivable one, if its effect grows in proportion and no density wave is found '// &
                          '(reliability --power looks for it by fits). Those that could move d by more than '// &
                          rounded_text(report%wanted/MILLIMETRE, 3)//' mm:')
        write (line, '(t3, a, t42, a10, t54, a, t63, a)') 'belief', 'value', 'unit', 'effect x, y, z, mm'
        call console%line(trim(line))
        call results%begin_array('reliability')
        do i = 1, size(report%values)
            associate (test => report%values(i), belief => BELIEFS(report%values(i)%belief))
                detectable = 'none'
                smallest = test%detectable/belief%size
                if (test%detectable > test%largest) smallest = 0
                if (smallest > 0) write (detectable, '(es10.2)') smallest
                write (line, '(t3, a, t42, a10, t54, a, t60, 3f11.5)') trim(belief%subject), adjustr(detectable), &
                    belief%unit, abs(test%effect)/MILLIMETRE
                if (any(abs(test%effect) > report%wanted)) then
                    shown = shown + 1
                    call console%line(trim(line))
                end if
                call results%begin(on_one_line=.true.)
                call results%member('belief', trim(belief%subject))
                call results%member('detectable', smallest)
                call results%member('unit', trim(belief%unit))
                call results%member('effect_mm', abs(test%effect)/MILLIMETRE)
                call results%end()
            end associate
        end do
        call results%end()
        call console%line('  and '//integer_text(size(report%values) - shown)// &
                          ' that could not (--format json has them all)')
    end subroutine show_reliability

    !> What JSON has of a case beside the row of the table; its object is left open for the checks.
    subroutine put_details(calibration, bound, results)
        type(calibration_t), intent(in) :: calibration
        type(case_bound_t), intent(in) :: bound
        type(results_t), intent(inout) :: results

        integer :: i

        call results%begin()
        call results%member('case', trim(calibration%case%name))
        call results%begin('adds_by_mm')
        do i = 1, size(SOURCES)
            if (any(bound%by_source(:, i) > 0)) call results%member(trim(SOURCES(i)), bound%by_source(:, i)/MILLIMETRE)
        end do
        do i = 1, size(KNOWLEDGE_SOURCES)
            if (any(bound%by_knowledge(:, i) > 0)) &
                call results%member(trim(KNOWLEDGE_SOURCES(i)%name), bound%by_knowledge(:, i)/MILLIMETRE)
        end do
        call results%end()
        call results%begin('ellipsoid')
        call results%member('sigma_mm', bound%principal_sigma/MILLIMETRE)
        call results%member('directions', transpose(bound%direction))
        call results%end()
    end subroutine put_details

    !> The consider covariance of every source, and what its draws give. Estimated sources add nothing.
    subroutine print_checks(calibration, seed, runs, threads, console, results, error)
        type(calibration_t), intent(in) :: calibration
        integer(i8), intent(in) :: seed        !! Of the random numbers
        integer, intent(in) :: runs, threads
        type(console_t), intent(inout) :: console
        type(results_t), intent(inout) :: results
        type(error_t), allocatable, intent(out) :: error

        real(dp), parameter :: NOTHING = 1e-4_dp        ! of the noise: estimates are not iterated farther
        type(consider_check_t) :: check
        integer, parameter :: NUMBERS = 59              ! columns
        character(NUMBERS) :: line
        character(8) :: deviation(3)
        integer :: i, axis

        call console%paragraph('each source drawn in '//integer_text(runs)//' runs: considered sigma, mm, and '// &
                          'drawn minus considered, % (-: less than 1e-4 of the noise)')
        call results%begin_array('checks')
        do i = 1, size(KNOWLEDGE_SOURCES)
            call tell(console, trim(calibration%case%name)//', '//trim(KNOWLEDGE_SOURCES(i)%name))
            call check_consider(calibration%case, calibration%options, i, seed, runs, threads, check, error, console)
            if (allocated(error)) return
            deviation = '       -'
            do axis = 1, 3
                if (min(check%rms(axis), check%considered(axis)) > NOTHING*check%noise(axis)) &
                    write (deviation(axis), '(f8.1)') 100*(check%rms(axis)/check%considered(axis) - 1)
            end do
            write (line, '(t3, 3(f11.6, a8))') (check%considered(axis)/MILLIMETRE, deviation(axis), axis=1, 3)
            call console%line(line//'  '//wrapped(trim(size_text(check%knowledge_study_t)), NUMBERS + 3, console_width()))
            call results%begin(on_one_line=.true.)
            call results%member('source', trim(KNOWLEDGE_SOURCES(i)%name))
            call results%member('runs', runs)
            call results%member('considered_mm', check%considered/MILLIMETRE)
            call results%member('drawn_mm', check%rms/MILLIMETRE)
            call results%end()
        end do
        call results%end()
    end subroutine print_checks
end module gracecg_cli_bound
