!> What gracecg estimate says of an estimate: for people, as CSV, and as JSON.
module gracecg_cli_estimate_results
    use gracecg_base_text, only: pick_text
    use gracecg_observations_knowledge, only: operator_knowledge_t
    use gracecg_observations_observation_files, only: OBSERVATION_FILES, SETUP_FILE
    use gracecg_observations_observation_set, only: observation_set_t
    use gracecg_estimation_diagnostics, only: fit_diagnostics_t, diagnose
    use gracecg_estimation_fit_record, only: fit_record_t
    use gracecg_estimation_action, only: action_t, refuse_offset, ACTIONS, DO_NOT_USE
    use gracecg_estimation_verdict, only: verdict_t, judge
    use gracecg_estimation_solution, only: solution_t, state_sigmas, quaternion_sigmas, has_attitude, STATE_NAMES, STATE_UNITS, &
        STATE_DRIFT, STATE_BIAS, STATE_RATE, STATE_ATTITUDE
    use gracecg_planning_planner, only: say_next_manoeuvre
    use gracecg_cli_belief_results, only: show_beliefs, put_beliefs
    use gracecg_cli_calibration_json, only: put_action, put_input, put_observed, put_fit, put_verdict, put_fit_tables
    use gracecg_cli_page_program, only: make_page
    use gracecg_cli_work
    implicit none
    private
    public :: asked_estimate_t, judged_t, judge_estimate, show_estimate, show_iterations, publish_estimate, &
        publish_refusal, write_estimate_page

    !> What is made of an estimate.
    type :: judged_t
        type(fit_diagnostics_t) :: diagnostics      !! Of the fit, where there is one
        type(verdict_t) :: verdict                  !! With an action; with findings where there is a fit
    end type judged_t

    !> What was asked for.
    type :: asked_estimate_t
        character(:), allocatable :: folder         !! Of the observations
        character(:), allocatable :: algorithm      !! Its name
        character(:), allocatable :: options_file   !! Path; empty: none
    end type asked_estimate_t

    character(*), parameter :: COLUMNS = &
        'algorithm,dx_mm,dy_mm,dz_mm,sigma_x_mm,sigma_y_mm,sigma_z_mm,iterations,converged,condition,'// &
        'residual_rms_x_m_s2,residual_rms_y_m_s2,residual_rms_z_m_s2,'// &
        'alpha_x_m_s3,alpha_y_m_s3,alpha_z_m_s3,sigma_alpha_x_m_s3,sigma_alpha_y_m_s3,sigma_alpha_z_m_s3,'// &
        'beta_x_m_s2,beta_y_m_s2,beta_z_m_s2,sigma_beta_x_m_s2,sigma_beta_y_m_s2,sigma_beta_z_m_s2,'// &
        'q1,q2,q3,q4,sigma_q1,sigma_q2,sigma_q3,sigma_q4,'// &
        'omega_x_rad_s,omega_y_rad_s,omega_z_rad_s,sigma_omega_x_rad_s,sigma_omega_y_rad_s,sigma_omega_z_rad_s,'// &
        'variance_factor,edited_accelerometer,edited_star_camera,'// &
        'undetected_x_mm,undetected_y_mm,undetected_z_mm,contradicted,action,trim_axes'

contains

    !> The estimate in words and tables, what to do first.
    subroutine show_estimate(knowledge, solution, judged, console)
        type(operator_knowledge_t), intent(in) :: knowledge
        type(solution_t), intent(in) :: solution
        type(judged_t), intent(in) :: judged
        type(console_t), intent(inout) :: console

        character(40) :: line
        real(dp) :: sigma(3)
        integer :: i

        call console%paragraph(judged%verdict%action%text)
        sigma = sigmas(solution)
        call console%line(trim(knowledge%name)//', '//solution%algorithm// &
                          ': CG offset, from centre of mass to proof-mass centre, body axes')
        do i = 1, 3
            call console%line('  '//AXES(i)//fitting_text(solution%offset(i)/MILLIMETRE, 12)// &
                              ' mm   sigma'//fitting_text(sigma(i)/MILLIMETRE, 10)//' mm')
        end do
        call console%line('iterations        '//integer_text(solution%iterations)// &
                          trim(merge(' (converged)    ', ' (not converged)', solution%converged)))
        write (line, '("condition number  ", es9.2)') solution%condition
        call console%line(trim(line))
        call show_three('residual RMS', solution%residual_rms, 'm/s^2 (accelerometer x, y, z)', console)
        if (solution%variance_factor > 0) then
            call console%line('variance factor   '//rounded_text(solution%variance_factor, 5)// &
                              ' (1 when model and noise are right)')
            call show_three('noise level', solution%noise_level, 'm^2 s^-4/Hz', console)
            call show_three('noise corner', solution%noise_corner, 'Hz', console)
            call show_three('star camera sigma', solution%star_camera_sigma, 'rad (camera x, y, boresight)', console)
        end if
        if (allocated(solution%beliefs)) call show_beliefs(solution%beliefs, console)
        call console%line('')
        call console%line('at the epoch '//utc_text(knowledge%epoch)//' UTC, and what else was estimated')
        call console%table(other_values(solution))
    end subroutine show_estimate

    !> Diagnostics and verdict of an estimate, with what the next manoeuvre would give where there has to be one. Fails when the
    !> covariance has no eigenvalues, save of a refused estimate, whose fit is then not examined.
    subroutine judge_estimate(observations, solution, record, judged, error, refusal)
        type(observation_set_t), intent(in) :: observations
        type(solution_t), intent(in) :: solution
        type(fit_record_t), intent(in) :: record
        type(judged_t), intent(out) :: judged
        type(error_t), allocatable, intent(out) :: error
        character(*), intent(in), optional :: refusal   !! Why there is no offset to be used

        character(:), allocatable :: proposal

        if (present(refusal)) call refuse_offset(refusal, judged%verdict%action)
        if (.not. present(refusal)) call refuse_offset('too few samples to examine the fit', judged%verdict%action)
        if (.not. has_fit(record)) return
        call diagnose(observations%knowledge, solution, record, judged%diagnostics, error)
        if (allocated(error)) then
            if (present(refusal)) deallocate (error)
            return
        end if
        judged%verdict = judge(observations%knowledge, solution, record, judged%diagnostics, refusal)
        associate (action => judged%verdict%action)
            if (action%kind /= DO_NOT_USE .and. any(action%again)) then
                call say_next_manoeuvre(observations, merge(sigmas(solution), 0.0_dp, action%again), proposal)
                if (proposal /= '') action%text = action%text//', '//proposal
            end if
        end associate
    end subroutine judge_estimate

    !> Three numbers in a line.
    subroutine show_three(label, values, unit, console)
        character(*), intent(in) :: label, unit
        real(dp), intent(in) :: values(3)
        type(console_t), intent(inout) :: console

        character(120) :: line

        write (line, '(a, t19, 2(es10.3, ", "), es10.3, 1x, a)') label, values, unit
        call console%line(trim(line))
    end subroutine show_three

    pure function sigmas(solution) result(sigma)
        type(solution_t), intent(in) :: solution
        real(dp) :: sigma(3)        !! m

        integer :: i

        sigma = [(sqrt(solution%covariance(i, i)), i=1, 3)]
    end function sigmas

    !> A number with five decimals, or with an exponent where they do not fit into the width.
    pure function fitting_text(value, width) result(text)
        real(dp), intent(in) :: value
        integer, intent(in) :: width
        character(width) :: text

        write (text, '(f'//integer_text(width)//'.5)') value
        if (index(text, '*') > 0) write (text, '(es'//integer_text(width)//'.2)') value
    end function fitting_text

    !> Attitude, angular velocity, drift, bias, and what else an algorithm estimates, each with its sigma.
    function other_values(solution) result(table)
        type(solution_t), intent(in) :: solution
        type(data_table_t) :: table

        real(dp) :: sigma(size(STATE_NAMES)), q_sigma(4)
        integer :: i

        call table%column('name', 'a', 'quantity')
        call table%column('meaning', 'a', '')
        call table%column('value', 'es14.6', 'value')
        call table%column('sigma', 'es10.2', 'sigma')
        call table%column('unit', 'a', 'unit')
        sigma = state_sigmas(solution)
        q_sigma = quaternion_sigmas(solution)
        do i = 1, merge(4, 0, has_attitude(solution))
            call add_row('q'//achar(iachar('0') + i), 'attitude, inertial to body', solution%quaternion(i), q_sigma(i), '')
        end do
        call add_axes('omega_', 'angular velocity, body axes', solution%angular_velocity, sigma(STATE_RATE), 'rad/s')
        call add_axes('alpha_', 'drift of the acceleration', solution%drift, sigma(STATE_DRIFT), 'm/s^3')
        call add_axes('beta_', 'bias of the acceleration', solution%bias, sigma(STATE_BIAS), 'm/s^2')
        if (.not. allocated(solution%parameters)) return
        do i = 1, size(solution%parameters)
            associate (p => solution%parameters(i))
                call add_row(trim(p%name), '', p%value, p%sigma, pick_text(p%unit == '1', '', trim(p%unit)))
            end associate
        end do

    contains

        subroutine add_row(name, meaning, value, sigma, unit)
            character(*), intent(in) :: name, meaning, unit
            real(dp), intent(in) :: value, sigma

            call table%add(name, meaning)
            call table%add([value, sigma])
            call table%add(unit)
        end subroutine add_row

        subroutine add_axes(name, meaning, values, sigma, unit)
            character(*), intent(in) :: name, meaning, unit
            real(dp), intent(in) :: values(3), sigma(3)

            integer :: axis

            do axis = 1, 3
                call add_row(name//AXES(axis), meaning, values(axis), sigma(axis), unit)
            end do
        end subroutine add_axes
    end function other_values

    !> Every iteration, as the F77 program prints it: corrections, state, RMS of the residuals.
    subroutine show_iterations(solution, console)
        type(solution_t), intent(in) :: solution
        type(console_t), intent(inout) :: console

        type(data_table_t) :: table
        character(:), allocatable :: line
        character(10) :: digits
        integer :: i, k, place

        do i = 1, size(solution%history)
            associate (it => solution%history(i))
                call console%line(trim(it%fit)//', iteration '//integer_text(it%number))
                line = 'RMS of the residuals before ('//trim(it%residual_unit)//'):'
                do k = 1, size(it%residual_rms)
                    write (digits, '(es10.3)') it%residual_rms(k)
                    line = line//' '//trim(it%residual_names(k))//' '//trim(adjustl(digits))
                end do
                call console%paragraph(line)
                table = data_table_t()
                call table%column('name', 'a', 'parameter')
                call table%column('correction', 'es11.3', 'correction')
                call table%column('state', 'es18.10', 'state')
                do k = 1, size(it%names)
                    if (all(it%state_names /= it%names(k))) call add_row(it%names(k), k, 0)
                end do
                do k = 1, size(it%state_names)
                    place = findloc(it%names, it%state_names(k), 1)
                    call add_row(it%state_names(k), place, k)
                end do
                call console%table(table)
                call console%line('')
            end associate
        end do

    contains

        !> A parameter with its places among corrections and state; 0: it has none there.
        subroutine add_row(name, correction, state)
            character(*), intent(in) :: name
            integer, intent(in) :: correction, state

            call table%add(name)
            if (correction > 0) call table%add(solution%history(i)%correction(correction))
            if (correction == 0) call table%add_nothing()
            if (state > 0) call table%add(solution%history(i)%state(state))
            if (state == 0) call table%add_nothing()
        end subroutine add_row
    end subroutine show_iterations

    !> The estimate as CSV or JSON.
    subroutine publish_estimate(asked, observations, solution, record, judged, console, error)
        type(asked_estimate_t), intent(in) :: asked
        type(observation_set_t), intent(in) :: observations
        type(solution_t), intent(in) :: solution
        type(fit_record_t), intent(in) :: record    !! Of the same estimate
        type(judged_t), intent(in) :: judged        !! What was made of it
        type(console_t), intent(inout) :: console
        type(error_t), allocatable, intent(out) :: error

        type(results_t) :: results
        type(data_table_t) :: table

        call fill_table(solution, judged%verdict%action, table)
        if (console%format == 'json') call fill_results(asked, observations, solution, record, judged, results)
        call results%publish(table, console, error)
    end subroutine publish_estimate

    !> The action of an estimate that is refused, and in JSON what could be read and fitted.
    subroutine publish_refusal(asked, observations, solution, record, console, refusal)
        type(asked_estimate_t), intent(in) :: asked
        type(observation_set_t), intent(in) :: observations
        type(solution_t), intent(in) :: solution
        type(fit_record_t), intent(in) :: record    !! As far as it came
        type(console_t), intent(inout) :: console
        character(*), intent(in) :: refusal         !! Why there is no offset to be used

        type(judged_t) :: judged
        type(results_t) :: results
        type(data_table_t) :: table
        type(error_t), allocatable :: without       ! what the message of the refusal says in any case

        call judge_estimate(observations, solution, record, judged, without, refusal)
        call console%paragraph(judged%verdict%action%text)
        if (console%format /= 'json') return
        call table%columns_of(COLUMNS)
        call fill_results(asked, observations, solution, record, judged, results, refusal)
        call results%publish(table, console, without)
    end subroutine publish_refusal

    !> The page of the estimate. With a refusal it shows no offset, begins with the reason, and has what could be read and
    !> fitted. Fails when the page cannot be made.
    subroutine write_estimate_page(path, asked, observations, solution, record, judged, console, error, refusal)
        character(*), intent(in) :: path            !! Of the page
        type(asked_estimate_t), intent(in) :: asked
        type(observation_set_t), intent(in) :: observations     !! Without samples where they could not be read
        type(solution_t), intent(in) :: solution
        type(fit_record_t), intent(in) :: record    !! Of the same estimate, as far as it came
        type(judged_t), intent(in) :: judged        !! What was made of it, or of the refusal
        type(console_t), intent(in) :: console
        type(error_t), allocatable, intent(out) :: error
        character(*), intent(in), optional :: refusal   !! Why there is no offset to be used

        type(results_t) :: results
        type(data_table_t) :: table
        character(:), allocatable :: text

        if (present(refusal)) then
            call table%columns_of(COLUMNS)
        else
            call fill_table(solution, judged%verdict%action, table)
        end if
        call fill_results(asked, observations, solution, record, judged, results, refusal)
        call results%complete(table, console, text, error)
        if (.not. allocated(error)) call make_page(path, text, error)
    end subroutine write_estimate_page

    !> The row of numbers.
    subroutine fill_table(solution, action, table)
        type(solution_t), intent(in) :: solution
        type(action_t), intent(in) :: action
        type(data_table_t), intent(out) :: table

        real(dp) :: sigma(size(STATE_NAMES))

        sigma = state_sigmas(solution)
        call table%columns_of(COLUMNS)
        call table%add(solution%algorithm, [solution%offset, sigmas(solution)]/MILLIMETRE)
        call table%add(solution%iterations)
        call table%add(solution%converged)
        call table%add([solution%condition, solution%residual_rms, solution%drift, sigma(STATE_DRIFT), solution%bias, &
                        sigma(STATE_BIAS)])
        call table%add([solution%quaternion, quaternion_sigmas(solution)], has_attitude(solution))
        call table%add([solution%angular_velocity, sigma(STATE_RATE)])
        call table%add(solution%variance_factor, solution%variance_factor > 0)
        call table%add(real(solution%edited, dp))
        if (allocated(solution%beliefs)) then
            call table%add(solution%beliefs%undetected(.false.)/MILLIMETRE)
            call table%add(solution%beliefs%has_contradiction())
        else
            call table%add_nothing(4)
        end if
        call table%add(ACTIONS(action%kind), join(pack(AXES, action%trimmed), ' '))
    end subroutine fill_table

    !> Everything but the table. With a refusal there is no offset, but the fit if there was one.
    subroutine fill_results(asked, observations, solution, record, judged, results, refusal)
        type(asked_estimate_t), intent(in) :: asked
        type(observation_set_t), intent(in) :: observations
        type(solution_t), intent(in) :: solution
        type(fit_record_t), intent(in) :: record
        type(judged_t), intent(in) :: judged
        type(results_t), intent(inout) :: results
        character(*), intent(in), optional :: refusal

        associate (knowledge => observations%knowledge, read => allocated(observations%accelerometer_time))
            call results%open('estimate')
            call put_action(judged%verdict%action, results)
            if (read) call results%member('case', trim(knowledge%name))
            call results%member('observations', asked%folder)
            if (read) call results%member('epoch_utc', utc_text(knowledge%epoch))
            if (present(refusal)) then
                call results%member('refusal', refusal)
            else
                call put_solution(solution, results)
            end if
            call results%member('algorithm', asked%algorithm)
            call results%member('options_file', asked%options_file)
            call results%begin_array('inputs')
            call put_input(asked%folder//'/'//trim(OBSERVATION_FILES(SETUP_FILE)), results)
            if (asked%options_file /= '') call put_input(asked%options_file, results)
            call results%end()
            if (allocated(solution%warnings)) call results%member('remarks', solution%warnings)
            if (read) call put_observed(observations, results)
            if (allocated(judged%verdict%findings)) then
                call put_verdict(judged%verdict, results)
                call put_fit(knowledge, record, judged%diagnostics, results)
                call put_fit_tables(knowledge, record, judged%diagnostics, results)
            end if
        end associate
    end subroutine fill_results

    !> Whether the fit came so far that its residuals can be judged.
    pure logical function has_fit(record)
        type(fit_record_t), intent(in) :: record

        integer, parameter :: LEAST_SAMPLES = 40

        has_fit = allocated(record%residual) .and. allocated(record%covariance)
        if (has_fit) has_fit = size(record%epoch) >= LEAST_SAMPLES
    end function has_fit

    subroutine put_solution(solution, results)
        type(solution_t), intent(in) :: solution
        type(results_t), intent(inout) :: results

        real(dp) :: sigma(size(STATE_NAMES))
        integer :: i

        sigma = state_sigmas(solution)
        call results%member('offset_m', solution%offset)
        call results%begin('covariance')
        call results%member('names', STATE_NAMES)
        call results%member('units', STATE_UNITS)
        call results%member('matrix', solution%state_covariance)
        call results%end()
        if (has_attitude(solution)) call results%member('sigma_attitude_rad', sigma(STATE_ATTITUDE))
        call results%begin_array('parameters')
        if (allocated(solution%parameters)) then
            do i = 1, size(solution%parameters)
                associate (p => solution%parameters(i))
                    call results%begin(on_one_line=.true.)
                    call results%member('name', trim(p%name))
                    call results%member('value', p%value)
                    call results%member('sigma', p%sigma)
                    call results%member('unit', trim(p%unit))
                    call results%end()
                end associate
            end do
        end if
        call results%end()
        if (solution%variance_factor > 0) then
            call results%begin('noise')
            call results%member('accelerometer_level_m2_s4_hz', solution%noise_level)
            call results%member('accelerometer_corner_hz', solution%noise_corner)
            call results%member('star_camera_sigma_rad', solution%star_camera_sigma)
            call results%end()
        end if
        if (allocated(solution%beliefs)) call put_beliefs(solution%beliefs, results)
        if (allocated(solution%history)) then
            call results%begin_array('history')
            do i = 1, size(solution%history)
                associate (it => solution%history(i))
                    call results%begin()
                    call results%member('fit', trim(it%fit))
                    call results%member('iteration', it%number)
                    call put_values('residual_rms', it%residual_names, it%residual_rms, results)
                    call results%member('residual_unit', trim(it%residual_unit))
                    call put_values('correction', it%names, it%correction, results)
                    call put_values('state', it%state_names, it%state, results)
                    call results%end()
                end associate
            end do
            call results%end()
        end if
    end subroutine put_solution

    subroutine put_values(key, names, values, results)
        character(*), intent(in) :: key, names(:)
        real(dp), intent(in) :: values(:)
        type(results_t), intent(inout) :: results

        integer :: i

        call results%begin(key, on_one_line=.true.)
        do i = 1, size(values)
            call results%member(trim(names(i)), values(i))
        end do
        call results%end()
    end subroutine put_values
end module gracecg_cli_estimate_results
