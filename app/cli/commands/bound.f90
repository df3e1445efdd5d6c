!> gracecg bound: the least error with which a case's manoeuvre lets the CG offset be estimated.
module gracecg_cli_bound
    use gracecg_base_lapack, only: symmetric_eigen
    use gracecg_observations_parameters, only: BELIEF_UNIT, BELIEF_SIZE
    use gracecg_estimation_belief_report, only: belief_report_t, FAMILY_LEVEL, POWER
    use gracecg_estimation_joint_estimate, only: joint_options_t, joint_solution_t, joint_sigma, estimate_jointly
    use gracecg_estimation_run_information, only: run_information_t
    use gracecg_simulation_operator_errors, only: KNOWLEDGE_SOURCES => SOURCES
    use gracecg_planning_bound, only: case_bound_t, bound_of_case, reliability_of_case, information_of_case, SOURCES
    use gracecg_planning_leakage, only: leakage_pair_t, leakage_of_case
    use gracecg_cli_plan_results, only: add_leakage
    use gracecg_cli_work
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
                                '(default all, the six built-in ones), the drag a straight line in time; the worst '// &
                                'direction; and what is added by scale factors, rod gain, magnetometer bias, '// &
                                'inertia and unmodelled torque that are known only within the limits of the '// &
                                'group `a_priori` of the case file (consider covariance).', &
                                'gracecg bound front-1 back-1'//new_line('a')//'gracecg bound front-2 front-3 --joint')
        call add_study_options(arguments, '--cases')
        call arguments%add_option('--joint', '', 'also of all cases together, as calibrations of one offset: what one joint '// &
                                  'estimate could reach')
        call arguments%add_option('--leakage', '', 'also with the leakage of the rods into the accelerometer estimated, of '// &
                                  'one flight and of a second one half a revolution away')
        call add_study_options(arguments, '--format --options')
    end subroutine declare_bound

    !> Computes the limit of the cases and prints it.
    subroutine run_bound(arguments, console, misuse, error)
        type(arguments_t), intent(in) :: arguments
        type(console_t), intent(inout) :: console
        type(error_t), allocatable, intent(out) :: misuse, error

        type(study_t) :: study
        type(case_bound_t) :: bound
        type(leakage_pair_t) :: pair
        type(results_t) :: results
        type(data_table_t) :: table
        integer :: i

        call take_study(arguments, 'all', console, study, misuse, error, may_rest=.true.)
        if (allocated(misuse) .or. allocated(error)) return
        call table%columns_of(COLUMNS)
        call results%open('bound')
        call results%begin_array('cases')
        do i = 1, size(study%calibrations)
            associate (calibration => study%calibrations(i))
                call tell(console, 'bound, '//trim(calibration%case%name))
                call bound_of_case(calibration%case, calibration%options, bound, error)
                if (allocated(error)) return
                if (i > 1) call console%line('')
                call results%begin()
                call add_bound(calibration, bound, table, console, results)
                if (arguments%has('--leakage')) then
                    call leakage_of_case(calibration%case, pair, error)
                    if (allocated(error)) return
                    call add_leakage(pair, calibration%case, console, results)
                end if
                call add_reliability(calibration, console, results, error)
                if (allocated(error)) return
                call results%end()
            end associate
        end do
        call results%end()
        if (arguments%has('--joint')) call add_joint_bound(study%calibrations, table, console, results, error)
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
        type(data_table_t) :: rows
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
        call begin_rows('all of them together, mm', rows)
        call rows%add('noise alone', joint_sigma(noise)/MILLIMETRE)
        if (any(all_estimated%parameter_sigma > 0)) &
            call rows%add('with what is estimated, too', joint_sigma(all_estimated)/MILLIMETRE)
        call console%line('')
        call console%table(rows)
        call results%begin('joint')
        call results%member('noise_alone_mm', joint_sigma(noise)/MILLIMETRE)
        call results%member('sigma_mm', joint_sigma(all_estimated)/MILLIMETRE)
        call results%end()
        call table%add('joint', [[joint_sigma(all_estimated), sqrt(values(3))]/MILLIMETRE, directions(:, 3)])
        call table%add_nothing(3)
    end subroutine add_joint_bound

    !> A table for people: a label, and three lengths.
    subroutine begin_rows(heading, rows)
        character(*), intent(in) :: heading     !! Of the labels
        type(data_table_t), intent(out) :: rows

        call rows%column('label', 'a', heading)
        call axis_columns(rows, '', '_mm', 'f12.5', '')
    end subroutine begin_rows

    !> The bound, what is added to it, and its ellipsoid: as a row, for people, and what JSON has besides.
    subroutine add_bound(calibration, bound, table, console, results)
        type(calibration_t), intent(in) :: calibration
        type(case_bound_t), intent(in) :: bound
        type(data_table_t), intent(inout) :: table
        type(console_t), intent(inout) :: console
        type(results_t), intent(inout) :: results

        character(len(SOURCES)), allocatable :: estimated(:)
        type(data_table_t) :: rows, ellipsoid
        integer :: i

        call table%add(calibration%case%name, [[bound%sigma, bound%principal_sigma(3)]/MILLIMETRE, bound%direction(:, 3), &
                                               bound%consider_sigma/MILLIMETRE])
        call results%member('case', trim(calibration%case%name))
        call begin_rows(trim(calibration%case%name)//': least sigma of the CG offset, mm', rows)
        call rows%add('noise (Cramer-Rao bound)', bound%sigma/MILLIMETRE)
        call results%begin('adds_by_mm')
        do i = 1, size(SOURCES)
            call add_source(SOURCES(i), bound%by_source(:, i), '  adds by ')
        end do
        do i = 1, size(KNOWLEDGE_SOURCES)
            call add_source(KNOWLEDGE_SOURCES(i)%name, bound%by_knowledge(:, i), '  ')
        end do
        call results%end()
        call rows%add('all (consider covariance)', bound%consider_sigma/MILLIMETRE)
        call console%table(rows)
        associate (asked => calibration%options%optimal)
            estimated = pack(SOURCES(:3), [asked%estimate_scale_factors, asked%estimate_rod_gain, &
                                           asked%estimate_magnetometer_bias])
        end associate
        if (size(estimated) > 0) &
            call console%line('(with the a-priori sigmas of '//join(estimated, ', ')//', which are estimated, too)')
        if (bound%shadow_edge >= 0) call console%warn(trim(calibration%case%name)//': the edge of the Earth''s shadow is '// &
            'passed at '//rounded_text(bound%shadow_edge, 3)//' s: the bound is with the light estimated beside the offset; '// &
            'another time is better')
        call ellipsoid%column('label', 'a', 'error ellipsoid of the bound')
        call ellipsoid%column('sigma_mm', 'f12.5', 'sigma, mm')
        call axis_columns(ellipsoid, 'along_', '', 'f9.4', 'along')
        do i = 3, 1, -1
            call ellipsoid%add(trim(merge('  worst direction', '                 ', i == 3)))
            call ellipsoid%add([bound%principal_sigma(i)/MILLIMETRE, bound%direction(:, i)])
        end do
        call console%table(ellipsoid)
        call results%begin('ellipsoid')
        call results%member('sigma_mm', bound%principal_sigma/MILLIMETRE)
        call results%member('directions', transpose(bound%direction))
        call results%end()

    contains

        subroutine add_source(name, sigma, prefix)
            character(*), intent(in) :: name
            real(dp), intent(in) :: sigma(3)        !! m
            character(*), intent(in) :: prefix      !! Of its label

            if (.not. any(sigma > 0)) return
            call rows%add(prefix//name, sigma/MILLIMETRE)
            call results%member(trim(name), sigma/MILLIMETRE)
        end subroutine add_source
    end subroutine add_bound

    !> Of each thing that an operator believes, the smallest wrong value that the tests of `optimal` would find, and
    !> what it would do to the offset.
    subroutine add_reliability(calibration, console, results, error)
        type(calibration_t), intent(in) :: calibration
        type(console_t), intent(inout) :: console
        type(results_t), intent(inout) :: results
        type(error_t), allocatable, intent(out) :: error

        type(belief_report_t) :: report
        type(data_table_t) :: rows, added
        real(dp) :: smallest
        integer :: i

        call reliability_of_case(calibration%case, calibration%options, report, error)
        if (allocated(error)) return
        call begin_rows('what optimal does not estimate, mm', added)
        call added%add('  all that &a_priori states of it', report%stated/MILLIMETRE)
        call console%table(added)
        call results%member('stated_mm', report%stated/MILLIMETRE)
        call rows%column('belief', 'a', '  belief')
        call rows%column('detectable', 'es10.2', 'value')
        call rows%column('unit', 'a', 'unit')
        call axis_columns(rows, 'effect_', '_mm', 'f11.5', 'effect, mm')
        call results%begin_array('reliability')
        do i = 1, size(report%values)
            associate (test => report%values(i), belief => report%values(i)%belief)
                smallest = merge(0.0_dp, test%detectable/BELIEF_SIZE(belief), test%detectable > test%largest)
                call results%begin(on_one_line=.true.)
                call results%member('belief', trim(test%subject))
                call results%member('detectable', smallest)
                call results%member('unit', trim(BELIEF_UNIT(belief)))
                call results%member('effect_mm', abs(test%effect)/MILLIMETRE)
                call results%member('effect_as_stated_mm', abs(test%within)/MILLIMETRE)
                call results%end()
                if (all(abs(test%within) <= report%wanted)) cycle
                call rows%add('  '//test%subject, &
                              [min(test%stated, merge(test%detectable, test%largest, smallest > 0))/BELIEF_SIZE(belief)])
                call rows%add(BELIEF_UNIT(belief), abs(test%within)/MILLIMETRE)
            end associate
        end do
        call results%end()
        if (rows%row_count() == 0) then
            call console%paragraph('No single wrong belief could move d unseen by more than '// &
                                   rounded_text(report%wanted/MILLIMETRE, 3)//' mm, by three times what &a_priori states')
            return
        end if
        call console%paragraph('What a wrong belief could do unseen, by three times what &a_priori states, or by the smallest '// &
                               'value found with probability '//rounded_text(POWER, 2)//' (level '// &
                               rounded_text(FAMILY_LEVEL, 1)//' for all tests) where that is less. Those that could move d '// &
                               'by more than '//rounded_text(report%wanted/MILLIMETRE, 3)//' mm, of '// &
                               integer_text(size(report%values))//' (--format json has all):')
        call console%table(rows)
    end subroutine add_reliability
end module gracecg_cli_bound
