!> The verdict on a calibration: what to do, what was examined, the figures found, and a grade for each.
module gracecg_estimation_verdict
    use gracecg_base_kinds, only: dp
    use gracecg_base_constants, only: MILLIMETRE, AXES
    use gracecg_base_text, only: integer_text, rounded_text, join
    use gracecg_observations_knowledge, only: operator_knowledge_t
    use gracecg_estimation_solution, only: solution_t
    use gracecg_estimation_fit_record, only: fit_record_t
    use gracecg_estimation_diagnostics, only: fit_diagnostics_t, WHITENESS_LAGS
    use gracecg_estimation_fit_checks, only: DOUBTFUL, SIGNIFICANT, MISFITTING, MUCH_NOISE
    use gracecg_estimation_belief_words, only: say_counts, say_contradiction, say_undetected, say_untested, say_failed_tests
    use gracecg_estimation_action       ! with a list gfortran 12 -O0 ends with an internal error
    implicit none
    private
    public :: verdict_t, finding_t, judge, act_on, GRADE_GOOD, GRADE_DOUBTFUL, GRADE_BAD

    integer, parameter :: GRADE_GOOD = 1        !! As it should be
    integer, parameter :: GRADE_DOUBTFUL = 2    !! Usable, with the remark in mind
    integer, parameter :: GRADE_BAD = 3         !! Not to be relied upon

    character(*), parameter :: REFUSED = 'Refused'      !! Subject of the finding that there is no offset
    real(dp), parameter :: POOR_CONDITION = 1e8_dp
    !! Of the normal matrix with unit diagonal: half of the digits are lost
    real(dp), parameter :: BY_CHANCE = 4        !! Standard deviations of the residuals' ratio
    real(dp), parameter :: CORRELATED = 1e-3_dp !! Of the probability of whiteness
    real(dp), parameter :: NOT_ZERO = 3         !! Standard deviations of a torque that is not as believed

    !> One thing that was examined.
    type :: finding_t
        integer :: grade = GRADE_GOOD    !! One of the grades above
        character(:), allocatable :: subject    !! What was examined
        character(:), allocatable :: text       !! What was found, with figures
    end type finding_t

    !> What to do, and the findings that it rests on.
    type :: verdict_t
        type(action_t) :: action                        !! What to do, and why
        integer :: grade = GRADE_GOOD                   !! The worst of the findings
        type(finding_t), allocatable :: findings(:)     !! In the order of examination
    end type verdict_t

contains

    !> Judges a calibration by its diagnostics.
    function judge(knowledge, solution, record, diagnostics, refusal) result(verdict)
        type(operator_knowledge_t), intent(in) :: knowledge
        type(solution_t), intent(in) :: solution
        type(fit_record_t), intent(in) :: record
        type(fit_diagnostics_t), intent(in) :: diagnostics
        character(*), intent(in), optional :: refusal   !! Why the estimator refused the fit
        type(verdict_t) :: verdict

        integer :: axis, i

        allocate (verdict%findings(0))
        if (present(refusal)) call add(verdict, GRADE_BAD, REFUSED, refusal)
        if (.not. allocated(solution%warnings)) then
            call add(verdict, GRADE_BAD, REFUSED, 'no estimator gave this solution')
            call refuse_offset(verdict%findings(size(verdict%findings))%text, verdict%action)
            return
        end if
        call judge_solution(solution, verdict)
        call judge_accuracy(diagnostics, verdict)
        do axis = 1, 3
            call judge_residuals(axis, diagnostics, verdict)
        end do
        call judge_torque(record, verdict)
        call judge_beliefs(solution, verdict)
        do i = 1, size(solution%warnings)
            call add(verdict, GRADE_DOUBTFUL, 'Warning', solution%warnings(i)%text)
        end do
        if (.not. all(knowledge%star_camera_sigma > 0)) &
            call add(verdict, GRADE_DOUBTFUL, 'Noise of the star camera', 'the setup does not give it '// &
                     '(noise_about_axes): the sigmas leave it out')
        call take_action(knowledge, solution, record, diagnostics, verdict)
    end function judge

    subroutine add(verdict, grade, subject, text)
        type(verdict_t), intent(inout) :: verdict
        integer, intent(in) :: grade
        character(*), intent(in) :: subject, text

        type(finding_t), allocatable :: longer(:)
        integer :: n

        n = size(verdict%findings)
        allocate (longer(n + 1))
        longer(:n) = verdict%findings
        longer(n + 1)%grade = grade
        longer(n + 1)%subject = subject
        longer(n + 1)%text = text
        call move_alloc(longer, verdict%findings)
        verdict%grade = max(verdict%grade, grade)
    end subroutine add

    subroutine judge_solution(solution, verdict)
        type(solution_t), intent(in) :: solution
        type(verdict_t), intent(inout) :: verdict

        character(:), allocatable :: text

        if (solution%converged) then
            call add(verdict, GRADE_GOOD, 'Convergence', 'converged; iterations: '//integer_text(solution%iterations))
        else
            call add(verdict, GRADE_BAD, 'Convergence', 'not converged in '//integer_text(solution%iterations)//' iterations')
        end if
        if (solution%variance_factor > MUCH_NOISE**2) then
            text = 'its squares are '//rounded_text(solution%variance_factor, 3)//' times what noise makes: the model is not '// &
                'that of these data'
            if (solution%algorithm == 'sequential') &
                text = text//' (it takes as known what group optimal of the options asks for; use --algorithm optimal)'
            call add(verdict, GRADE_BAD, 'Fit', text)
        end if
        text = 'condition number '//trim(power_text(solution%condition))//' of the normal matrix with unit diagonal'
        if (solution%condition <= POOR_CONDITION) then
            call add(verdict, GRADE_GOOD, 'Condition', text//' (up to '//trim(power_text(POOR_CONDITION))//' is harmless)')
        else
            call add(verdict, GRADE_DOUBTFUL, 'Condition', text//': more than half of the digits are lost, some combination '// &
                     'of the parameters is hardly observable')
        end if
    end subroutine judge_solution

    subroutine judge_accuracy(diagnostics, verdict)
        type(fit_diagnostics_t), intent(in) :: diagnostics
        type(verdict_t), intent(inout) :: verdict

        character(:), allocatable :: figures

        if (.not. diagnostics%sigma_known) then
            call add(verdict, GRADE_DOUBTFUL, 'Accuracy', 'not known: the setup lacks the noise_level of an '// &
                     'accelerometer axis, so the sigmas leave its noise out')
            return
        end if
        associate (d => diagnostics, long => diagnostics%ellipsoid%semi_axis(1))
            figures = 'sigma '//rounded_text(d%sigma(1)/MILLIMETRE, 3)//', '// &
                rounded_text(d%sigma(2)/MILLIMETRE, 3)//', '//rounded_text(d%sigma(3)/MILLIMETRE, 3)//' mm in x, y, z; '// &
                'worst direction '//trim(direction_text(d%ellipsoid%direction(:, 1)))//' with '// &
                rounded_text(long/MILLIMETRE, 3)//' mm'
            if (all(d%sigma <= WANTED_ACCURACY)) then
                call add(verdict, GRADE_GOOD, 'Accuracy', figures//'; wanted are '// &
                         rounded_text(WANTED_ACCURACY/MILLIMETRE, 2)//' mm')
            else
                call add(verdict, GRADE_DOUBTFUL, 'Accuracy', figures//': '//trim(listed_axes(d%sigma > WANTED_ACCURACY))// &
                         trim(merge(' is ', ' are', count(d%sigma > WANTED_ACCURACY) == 1))// &
                         ' not determined to the wanted '//rounded_text(WANTED_ACCURACY/MILLIMETRE, 2)//' mm')
            end if
        end associate
    end subroutine judge_accuracy

    subroutine judge_residuals(axis, diagnostics, verdict)
        integer, intent(in) :: axis
        type(fit_diagnostics_t), intent(in) :: diagnostics
        type(verdict_t), intent(inout) :: verdict

        character(:), allocatable :: subject, text
        logical :: chance, white

        subject = 'Residuals '//AXES(axis)
        associate (r => diagnostics%residuals(axis))
            text = 'RMS '//rounded_text(r%rms, 3)//' m/s^{2}, '
            if (.not. r%noise_known) then
                call add(verdict, GRADE_DOUBTFUL, subject, text//'but the setup gives no noise_level of this '// &
                         'axis to compare with: the sigmas leave it out')
                return
            end if
            text = text//rounded_text(r%ratio, 3)//' times what the noise of the setup explains (by chance: '// &
                rounded_text(max(0.0_dp, 1 - BY_CHANCE*r%ratio_sigma), 2)//' to '// &
                rounded_text(1 + BY_CHANCE*r%ratio_sigma, 3)//')'
            chance = abs(r%ratio - 1) <= BY_CHANCE*r%ratio_sigma
            white = r%probability >= CORRELATED
            if (white) then
                text = text//'; whitened, they are white (probability '//rounded_text(r%probability, 2)//')'
            else
                text = text//'; whitened, they are correlated over '//integer_text(WHITENESS_LAGS)// &
                    ' samples (probability of white noise below '//rounded_text(CORRELATED, 1)//')'
            end if
            if (r%peak_counts) then
                text = text//'; their spectrum is highest at '//rounded_text(r%peak_frequency, 3)//' Hz, '// &
                    rounded_text(r%peak_ratio, 2)//' times the expected'
            end if
            if (r%ratio > MUCH_NOISE) then
                call add(verdict, GRADE_BAD, subject, text//': a wrong unit, faulty samples or strong forces '// &
                         'that the fit does not know')
            else if (chance .and. .not. r%peak_counts) then
                if (.not. white) text = text//': something small is there besides, such as drag that bends a little'
                call add(verdict, GRADE_GOOD, subject, text)
            else if (r%ratio < 1 .and. .not. r%peak_counts) then
                call add(verdict, GRADE_DOUBTFUL, subject, text//': the noise of the setup is not that of '// &
                         'the instrument, so neither are the sigmas')
            else
                call add(verdict, GRADE_DOUBTFUL, subject, text//': a force that is not a straight line in '// &
                         'time (drag), or more noise than the setup says; the sigmas leave it out')
            end if
        end associate
    end subroutine judge_residuals

    subroutine judge_torque(record, verdict)
        type(fit_record_t), intent(in) :: record
        type(verdict_t), intent(inout) :: verdict

        character(:), allocatable :: text

        if (.not. record%torque_checked) then
            call add(verdict, GRADE_DOUBTFUL, 'Torque', 'not compared with the rotation that the star camera saw')
            return
        end if
        text = 'the satellite turned as by '//rounded_text(record%torque_factor, 3)//' times (sigma '// &
            rounded_text(record%torque_sigma, 2)//') the torque that the setup says'
        if (abs(record%torque_factor - 1) <= NOT_ZERO*record%torque_sigma) then
            call add(verdict, GRADE_GOOD, 'Torque', text)
        else
            call add(verdict, GRADE_DOUBTFUL, 'Torque', text//': the offset may be off by as much')
        end if
        if (.not. record%attitude_misfit > 0) return
        text = 'residuals of the star camera '//rounded_text(record%attitude_misfit, 3)//' times their noise'
        call add(verdict, merge(GRADE_GOOD, GRADE_DOUBTFUL, record%attitude_misfit <= MISFITTING), 'Attitude', text)
    end subroutine judge_torque

    !> What the data say of the operator's beliefs: confirmed, contradicted, or not to be tested here.
    subroutine judge_beliefs(solution, verdict)
        type(solution_t), intent(in) :: solution
        type(verdict_t), intent(inout) :: verdict

        character(:), allocatable :: text, part

        if (.not. allocated(solution%beliefs)) then
            call add(verdict, GRADE_DOUBTFUL, 'What the setup says', 'not tested against the data')
            return
        end if
        associate (report => solution%beliefs)
            call say_counts(report, text)
            call say_undetected(report, .true., part)
            text = text//'; undetected a single wrong one could move the offset in '//part//', by three times what is stated'
            call say_undetected(report, .false., part)
            text = text//'; if that does not hold, in '//part
            call say_contradiction(report, part)
            if (part /= '') then
                call add(verdict, GRADE_BAD, 'Contradicted', part)
            else
                call add(verdict, GRADE_GOOD, 'Contradicted', 'nothing that the setup says, at the level of one false '// &
                         'alarm in a thousand calibrations')
            end if
            call add(verdict, merge(GRADE_DOUBTFUL, GRADE_GOOD, any(report%undetected(.true.) > report%wanted)), 'Beliefs', &
                     text)
            call say_untested(report, part)
            if (part /= '') call add(verdict, GRADE_DOUBTFUL, 'Not testable here', part)
        end associate
    end subroutine judge_beliefs

    !> What to do: nothing that is bad is used, and no more is trusted than could be tested.
    subroutine take_action(knowledge, solution, record, diagnostics, verdict)
        type(operator_knowledge_t), intent(in) :: knowledge
        type(solution_t), intent(in) :: solution
        type(fit_record_t), intent(in) :: record
        type(fit_diagnostics_t), intent(in) :: diagnostics
        type(verdict_t), intent(inout) :: verdict

        logical :: contradicted
        real(dp) :: torque_off
        integer :: bad

        contradicted = .false.
        if (allocated(solution%beliefs)) contradicted = solution%beliefs%has_contradiction()
        bad = findloc(verdict%findings%grade, GRADE_BAD, 1)
        if (bad > 0) contradicted = contradicted .and. verdict%findings(bad)%subject /= REFUSED
        if (bad > 0 .and. .not. contradicted) then
            associate (found => verdict%findings(bad))
                if (found%subject == REFUSED) then
                    call refuse_offset(found%text, verdict%action)
                else
                    call refuse_offset(found%subject//': '//found%text, verdict%action)
                end if
            end associate
        else if (.not. (contradicted .or. diagnostics%sigma_known .or. all(solution%noise_level > 0))) then
            call refuse_offset('the accuracy is not known, for lack of noise levels in setup.nml: give noise_level and '// &
                               'noise_about_axes, and estimate again', verdict%action)
        else
            torque_off = 0
            if (record%torque_checked) torque_off = record%torque_factor - 1
            if (abs(torque_off) <= max(DOUBTFUL, SIGNIFICANT*record%torque_sigma)) torque_off = 0
            call act_on(solution, knowledge%mass, verdict%action, torque_off)
        end if
    end subroutine take_action

    !> What to do with a solution whose noise is known, by its tests.
    subroutine act_on(solution, mass, action, torque_off)
        type(solution_t), intent(in) :: solution
        real(dp), intent(in) :: mass                    !! Of the satellite, kg
        type(action_t), intent(out) :: action
        real(dp), intent(in), optional :: torque_off    !! By which the satellite turned otherwise than the rods should have made
        !! it, relative: the offset may be off by as much

        type(known_offset_t) :: known
        character(:), allocatable :: contradiction, text

        if (.not. allocated(solution%beliefs)) then
            call say_failed_tests(solution%warnings, text)
            if (text /= '') then
                call refuse_offset(text, action)
            else
                action%kind = NOT_TESTED
                action%text = 'not tested: the options leave out the tests of what the setup says (test_beliefs, covariance); '// &
                    'estimate with them before masses move'
            end if
            return
        end if
        associate (report => solution%beliefs)
            call say_contradiction(report, contradiction)
            if (contradiction /= '' .or. .not. solution%converged) then
                if (contradiction == '') contradiction = 'not converged'
                call refuse_offset(contradiction, action)
                return
            end if
            known = known_of(solution%offset, solution%covariance, report)
            if (present(torque_off)) known%sigma = sqrt(known%sigma**2 + (torque_off*known%value)**2)
            call decide(known, mass, action)
        end associate
    end subroutine act_on

    !> '4.9E+03'.
    function power_text(value) result(text)
        real(dp), intent(in) :: value
        character(12) :: text

        character(12) :: buffer

        write (buffer, '(es12.1)') value
        text = trim(adjustl(buffer))
    end function power_text

    !> '(0.99, -0.01, 0.05)'.
    function direction_text(direction) result(text)
        real(dp), intent(in) :: direction(3)
        character(26) :: text

        character(5) :: parts(3)

        write (parts, '(f5.2)') merge(direction, 0.0_dp, abs(direction) >= 0.005_dp)
        text = '('//join(adjustl(parts), ', ')//')'
    end function direction_text
end module gracecg_estimation_verdict
