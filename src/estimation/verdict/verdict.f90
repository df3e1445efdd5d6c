!> The verdict on a calibration: what was examined, the figures found, a grade for each, and which steps
!> follow. How to take a step is for whoever shows the verdict.
module gracecg_estimation_verdict
    use gracecg_base_kinds, only: dp
    use gracecg_base_constants, only: MILLIMETRE, AXES
    use gracecg_base_text, only: integer_text, rounded_text, join
    use gracecg_observations_knowledge, only: operator_knowledge_t
    use gracecg_estimation_solution, only: solution_t
    use gracecg_estimation_fit_record, only: fit_record_t
    use gracecg_estimation_diagnostics, only: fit_diagnostics_t, WHITENESS_LAGS
    use gracecg_estimation_fit_checks, only: MISFITTING, MUCH_NOISE
    use gracecg_estimation_belief_words, only: say_counts, say_contradiction, say_undetected, say_untested
    implicit none
    private
    public :: verdict_t, finding_t, next_step_t, judge, listed_axes, WANTED_ACCURACY, NOT_ZERO
    public :: GRADE_GOOD, GRADE_DOUBTFUL, GRADE_BAD
    public :: STEP_MEND, STEP_GIVE_NOISE, STEP_TRIM, STEP_LEAVE, STEP_REPEAT, STEP_LOWER_LIMIT, STEP_RECALIBRATE, STEP_TEST

    integer, parameter :: GRADE_GOOD = 1        !! As it should be
    integer, parameter :: GRADE_DOUBTFUL = 2    !! Usable, with the remark in mind
    integer, parameter :: GRADE_BAD = 3         !! Not to be relied upon

    integer, parameter :: STEP_MEND = 1         !! Mend the faults, or leave the samples out; else calibrate again
    integer, parameter :: STEP_GIVE_NOISE = 2   !! Give the noise levels and estimate again
    integer, parameter :: STEP_TRIM = 3         !! Move the centre of mass along some axes
    integer, parameter :: STEP_LEAVE = 4        !! Leave some axes as they are
    integer, parameter :: STEP_REPEAT = 5       !! Calibrate again with another manoeuvre for some axes
    integer, parameter :: STEP_LOWER_LIMIT = 6  !! Take the sigmas for a lower limit
    integer, parameter :: STEP_RECALIBRATE = 7  !! Calibrate again after the trim
    integer, parameter :: STEP_TEST = 8         !! Test what matters and could not be tested, before any trim

    real(dp), parameter :: WANTED_ACCURACY = 1e-4_dp
    !! Of each component of the offset, m: what CSR-TM-00-01 Table 1.2 asks of its stability
    real(dp), parameter :: POOR_CONDITION = 1e8_dp
    !! Of the normal matrix with unit diagonal: half of the digits are lost
    real(dp), parameter :: BY_CHANCE = 4        !! Standard deviations of the residuals' ratio
    real(dp), parameter :: CORRELATED = 1e-3_dp !! Of the probability of whiteness
    real(dp), parameter :: NOT_ZERO = 3         !! Standard deviations of a component that is not 0

    !> One thing that was examined.
    type :: finding_t
        integer :: grade = GRADE_GOOD    !! One of the grades above
        character(:), allocatable :: subject    !! What was examined
        character(:), allocatable :: text       !! What was found, with figures
    end type finding_t

    !> Something to do.
    type :: next_step_t
        integer :: kind = 0                             !! STEP_...
        logical :: axes(3) = .false.                    !! Of the offset, with which it is to do
    end type next_step_t

    !> The findings and what follows from them.
    type :: verdict_t
        integer :: grade = GRADE_GOOD                   !! The worst of the findings
        character(:), allocatable :: summary            !! One sentence
        type(finding_t), allocatable :: findings(:)    !! In the order of examination
        type(next_step_t), allocatable :: next_steps(:) !! What to do, the first thing first
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

        allocate (verdict%findings(0), verdict%next_steps(0))
        if (present(refusal)) call add(verdict, GRADE_BAD, 'Refused', refusal)
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
        call sum_up(solution, diagnostics, verdict)
        call advise(solution, diagnostics, verdict)
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
            rounded_text(record%torque_sigma, 2)//') the torque of rods and magnetic field'
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
            call say_undetected(report, part)
            text = text//'; undetected a single wrong one could move the offset in '//part
            call say_contradiction(report, part)
            if (part /= '') then
                call add(verdict, GRADE_BAD, 'Contradicted', part)
            else
                call add(verdict, GRADE_GOOD, 'Contradicted', 'nothing that the setup says, at the level of one false '// &
                         'alarm in a thousand calibrations')
            end if
            call add(verdict, merge(GRADE_DOUBTFUL, GRADE_GOOD, any(report%undetected() > report%wanted)), 'Beliefs', text)
            call say_untested(report, part)
            if (part /= '') call add(verdict, GRADE_DOUBTFUL, 'Not testable here', part)
        end associate
    end subroutine judge_beliefs

    !> The verdict in one sentence.
    subroutine sum_up(solution, diagnostics, verdict)
        type(solution_t), intent(in) :: solution
        type(fit_diagnostics_t), intent(in) :: diagnostics
        type(verdict_t), intent(inout) :: verdict

        character(:), allocatable :: text
        logical :: determined(3)

        determined = diagnostics%sigma <= WANTED_ACCURACY
        if (verdict%grade == GRADE_BAD) then
            text = 'Do not use this offset: see what is marked below.'
        else if (.not. diagnostics%sigma_known) then
            text = 'The accuracy is not known, for lack of noise levels in the setup'
        else if (all(determined)) then
            text = 'All three components are determined to '//rounded_text(WANTED_ACCURACY/MILLIMETRE, 2)//' mm or better'
        else if (any(determined)) then
            text = trim(listed_axes(determined))//trim(merge(' is ', ' are', count(determined) == 1))// &
                ' determined to '//rounded_text(WANTED_ACCURACY/MILLIMETRE, 2)//' mm or better, '// &
                trim(listed_axes(.not. determined))//trim(merge(' is ', ' are', count(.not. determined) == 1))//' not'
        else
            text = 'No component is determined to '//rounded_text(WANTED_ACCURACY/MILLIMETRE, 2)//' mm'
        end if
        if (verdict%grade /= GRADE_BAD) then
            if (size(solution%warnings) > 0) text = text//'; the observations gave reason for warnings'
            text = text//'.'
        end if
        call move_alloc(text, verdict%summary)
    end subroutine sum_up

    !> What to do next.
    subroutine advise(solution, diagnostics, verdict)
        type(solution_t), intent(in) :: solution
        type(fit_diagnostics_t), intent(in) :: diagnostics
        type(verdict_t), intent(inout) :: verdict

        logical :: determined(3), moved(3), excess, untested

        if (verdict%grade == GRADE_BAD) then
            verdict%next_steps = [next_step_t(STEP_MEND)]
            return
        end if
        if (.not. diagnostics%sigma_known) then
            verdict%next_steps = [next_step_t(STEP_GIVE_NOISE)]
            return
        end if
        determined = diagnostics%sigma <= WANTED_ACCURACY
        moved = determined .and. abs(solution%offset) > NOT_ZERO*diagnostics%sigma
        excess = any(diagnostics%residuals%noise_known .and. diagnostics%residuals%ratio > &
                     1 + BY_CHANCE*diagnostics%residuals%ratio_sigma)
        untested = .false.
        if (allocated(solution%beliefs)) untested = solution%beliefs%is_untested()
        if (untested) then              ! nothing is moved by what might be wrong unseen
            call add_step(STEP_TEST, [.true., .true., .true.])
        else
            call add_step(STEP_TRIM, moved)
            call add_step(STEP_LEAVE, determined .and. .not. moved)
        end if
        call add_step(STEP_REPEAT, .not. determined)
        call add_step(STEP_LOWER_LIMIT, spread(excess, 1, 3))
        if (.not. untested) call add_step(STEP_RECALIBRATE, moved)

    contains

        !> Where it is to do with an axis.
        subroutine add_step(kind, chosen)
            integer, intent(in) :: kind
            logical, intent(in) :: chosen(3)

            if (any(chosen)) verdict%next_steps = [verdict%next_steps, next_step_t(kind, chosen)]
        end subroutine add_step
    end subroutine advise

    !> '4.9E+03'.
    function power_text(value) result(text)
        real(dp), intent(in) :: value
        character(12) :: text

        character(12) :: buffer

        write (buffer, '(es12.1)') value
        text = trim(adjustl(buffer))
    end function power_text

    !> The axes that are chosen: 'x', 'x and z'.
    function listed_axes(chosen) result(text)
        logical, intent(in) :: chosen(3)        !! x, y, z
        character(10) :: text

        character(1), allocatable :: names(:)

        names = pack(AXES, chosen)
        associate (n => size(names))
            text = ''
            if (n == 1) text = names(1)
            if (n > 1) text = join(names(:n - 1), ', ')//' and '//names(n)
        end associate
    end function listed_axes

    !> '(0.99, -0.01, 0.05)'.
    function direction_text(direction) result(text)
        real(dp), intent(in) :: direction(3)
        character(26) :: text

        character(5) :: parts(3)

        write (parts, '(f5.2)') merge(direction, 0.0_dp, abs(direction) >= 0.005_dp)
        text = '('//join(adjustl(parts), ', ')//')'
    end function direction_text
end module gracecg_estimation_verdict
